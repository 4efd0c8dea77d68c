"""What is laid over the picture: shapes, their messages, drawings, films and a live view."""
