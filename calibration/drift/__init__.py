"""Whether cameras and screen still stand where they stood, from a few dots on the screen."""
