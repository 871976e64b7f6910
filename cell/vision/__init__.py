"""What pictures tell: blocks on the playground."""

from cell.vision.blocks import SeenBlock, find_blocks, locate
from cell.vision.settings import RecognitionSettings

__all__ = ["RecognitionSettings", "SeenBlock", "find_blocks", "locate"]
