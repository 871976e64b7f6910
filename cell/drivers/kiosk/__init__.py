"""The television's picture: a page that a browser shows full screen, and what it confirms."""

from cell.drivers.kiosk.messages import PageView, Painted
from cell.drivers.kiosk.screen import KioskScreen
from cell.drivers.kiosk.settings import KioskSettings
from cell.drivers.kiosk.telling import ScreenTold, ask_screen

__all__ = ["KioskScreen", "KioskSettings", "PageView", "Painted", "ScreenTold", "ask_screen"]
