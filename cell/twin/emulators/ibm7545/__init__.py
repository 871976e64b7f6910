"""An IBM 7545 behind a bridge: the slave's registers and program, motors and joints."""

from cell.twin.emulators.ibm7545.bridge import RegisterBridge
from cell.twin.emulators.ibm7545.settings import SlaveSettings
from cell.twin.emulators.ibm7545.slave import KeptSlave, Slave

__all__ = ["KeptSlave", "RegisterBridge", "Slave", "SlaveSettings"]
