"""The television's picture: a page that a browser shows full screen, and what it confirms."""

from cell.drivers.kiosk.messages import PageView, Painted
from cell.drivers.kiosk.screen import KioskScreen
from cell.drivers.kiosk.settings import KioskSettings

__all__ = ["KioskScreen", "KioskSettings", "PageView", "Painted"]
