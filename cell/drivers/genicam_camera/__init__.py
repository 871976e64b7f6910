"""GigE Vision and USB3 Vision cameras through GenICam (the extra `genicam`)."""
