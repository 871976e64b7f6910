"""The arm's servos as joints: angles to pulses and back, what was sent, and what is told."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cell.clock import Clock
from cell.drivers.ssc32.commands import Move, ServoTarget
from cell.drivers.ssc32.panel import ServoPanel, agree
from cell.drivers.ssc32.servo_map import speed_cap_us_s
from cell.drivers.ssc32.settings import Ssc32Settings
from cell.errors import DeviceError, DeviceTimeout
from cell.geometry import JointPositions
from cell.kinematics.lynx import LynxArm

_MOVING_US = 50
"""How far pulses may change between two questions while the arm moves."""
_HOLD_LOOKS = 25
_HOLD_PAUSE_S = 0.02
_OPEN_HINT = "support the arm, then open it again; its first move jumps"


class ServoJoints:
    """What is known of the joints, which is what they were commanded.

    Args:
        panel: The controller.
        clock: What pauses are taken on.
        device: Name of the device in messages.
        settings: The servos.
        kinematics: The joints' limits and speeds.

    Attributes:
        channels: The servos' channels, J1 first.
        were_lost: Whether servos were found without pulses since somebody set this to False.
    """

    def __init__(
        self,
        panel: ServoPanel,
        clock: Clock,
        device: str,
        settings: Ssc32Settings,
        kinematics: LynxArm,
    ) -> None:
        self._panel = panel
        self._clock = clock
        self._device = device
        self._settings = settings
        self.channels = tuple(servo.channel for servo in settings.servos)
        self.were_lost = False
        self._caps_us_s = tuple(
            speed_cap_us_s(servo.map, low, high, speed, settings.segment_s)
            for servo, low, high, speed in zip(
                settings.servos,
                kinematics.joint_min,
                kinematics.joint_max,
                kinematics.joint_speed,
                strict=True,
            )
        )
        self._sent_us: tuple[int, ...] | None = None

    def pulses(self, joints: JointPositions) -> tuple[int, ...]:
        """Return the pulse widths of joint angles, in whole microseconds."""
        return tuple(
            min(max(round(servo.map.pulse_us(angle)), servo.min_us), servo.max_us)
            for servo, angle in zip(self._settings.servos, joints.values, strict=True)
        )

    def angles(self, pulses_us: Sequence[int]) -> JointPositions:
        """Return the joint angles that pulse widths stand for."""
        return JointPositions(
            tuple(
                servo.map.position(pulse)
                for servo, pulse in zip(self._settings.servos, pulses_us, strict=True)
            )
        )

    def send(self, pulses_us: tuple[int, ...], duration_s: float) -> None:
        """Start a move of all joints together, none faster than it may."""
        self._sent_us = pulses_us
        time_ms = max(1, math.ceil(duration_s * 1000.0 - 1e-6))
        self._panel.move(Move(self._targets(pulses_us), time_ms))

    def send_first(self, index: int, pulse_us: int) -> None:
        """Send one joint its first pulse since power-up; it jumps there."""
        self._panel.move(Move((ServoTarget(self.channels[index], pulse_us),)))

    def stop(self) -> None:
        """Stop any motion now; servos without pulses are left alone.

        Raises:
            DeviceError: The answers are strange.
            DeviceTimeout: The controller does not answer, or goes on moving.
        """
        if self._settings.knows_stop:
            self._panel.stop_servos(self.channels)
        is_moving, sent = self._panel.is_moving(), self._sent_us
        pulses_us = self._panel.sure_pulses_us(self.channels, sent, within_us=_MOVING_US)
        # One strange answer must not keep a moving arm from being stopped.
        if not is_moving and (sent is None or agree(sent, pulses_us)):
            return
        held = self._targets(pulses_us)
        if held:
            self._panel.move(Move(held))
            self._await_held()
        self._sent_us = pulses_us if all(pulses_us) else None

    def told_us(self) -> tuple[int, ...]:
        """Return the pulses of an arm at rest, believed only if told twice or sent."""
        return self._panel.sure_pulses_us(self.channels, self._sent_us)

    def told_on_the_way_us(self) -> tuple[int, ...]:
        """Return pulses that may be changing; that there are none is believed if told twice."""
        pulses_us = self._panel.pulses_us(self.channels)
        if all(pulses_us):
            return pulses_us
        return self._panel.sure_pulses_us(self.channels, within_us=_MOVING_US)

    def standing(self) -> JointPositions:
        """Return the commanded joint angles, asked for now.

        Raises:
            DeviceError: A servo has no pulses.
            DeviceTimeout: The controller does not answer.
        """
        pulses_us = self.told_us()
        self.require_pulses(pulses_us)
        self.adopt(pulses_us)
        return self.angles(self._sent_us or pulses_us)

    def adopt(self, pulses_us: tuple[int, ...]) -> None:
        """Take over what the controller commands, more exactly where it was sent from here."""
        sent = self._sent_us
        if sent is None or not agree(sent, pulses_us):
            self._sent_us = pulses_us

    def forget(self) -> None:
        """Forget what was sent: the controller was restarted."""
        self._sent_us = None

    def require_at(self, pulses_us: tuple[int, ...]) -> None:
        """Return if the controller commands these pulses.

        Raises:
            DeviceError: It commands others, or none.
        """
        now_us = self._panel.sure_pulses_us(self.channels, pulses_us)
        self.require_pulses(now_us)
        if not agree(pulses_us, now_us):
            raise DeviceError(
                self._device,
                f"the move ended at {self.angles(now_us)} deg instead of "
                f"{self.angles(pulses_us)} deg",
                hint="an order was lost on the line, or somebody else sends to the controller",
            )

    def require_pulses(self, pulses_us: Sequence[int]) -> None:
        """Return if every servo has pulses.

        Raises:
            DeviceError: One has none: the controller was restarted.
        """
        if not all(pulses_us):
            self._sent_us = None
            self.were_lost = True
            raise DeviceError(self._device, self.unpulsed(pulses_us), hint=_OPEN_HINT)

    def unpulsed(self, pulses_us: Sequence[int]) -> str:
        """Return which joints have no pulses, as a sentence."""
        names = [f"J{number}" for number, pulse in enumerate(pulses_us, 1) if not pulse]
        return f"since its power-up the controller has sent no pulses to {', '.join(names)}"

    def advice(self, pulses_us: Sequence[int]) -> str:
        """Return what is wrong with the pulses and what to do, empty if nothing."""
        return "" if all(pulses_us) else f"{self.unpulsed(pulses_us)}; {_OPEN_HINT}"

    def _targets(self, pulses_us: Sequence[int]) -> tuple[ServoTarget, ...]:
        return tuple(
            ServoTarget(channel, pulse, cap)
            for channel, pulse, cap in zip(self.channels, pulses_us, self._caps_us_s, strict=True)
            if pulse
        )

    def _await_held(self) -> None:
        """Wait until the arm stands that was told to stay where it is."""
        for _ in range(_HOLD_LOOKS):
            if not self._panel.is_moving():
                return
            self._clock.sleep(_HOLD_PAUSE_S)
        raise DeviceTimeout(
            self._device,
            f"still moving {_HOLD_LOOKS * _HOLD_PAUSE_S:g} s after it was told to stop",
            hint="switch the servo supply off; check that nobody else sends to the controller",
        )
