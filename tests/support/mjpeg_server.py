"""A real HTTP server on the loopback whose pictures (multipart JPEG) carry their number."""

import base64
import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np

BITS = 16


def jpeg_picture(number):
    """A picture whose bars are the bits of its number: JPEG cannot blur that away."""
    picture = np.empty((48, 64), np.uint8)
    for bit in range(BITS):
        picture[:, bit * 4 : (bit + 1) * 4] = 220 if number >> bit & 1 else 30
    return picture


def number_in(picture):
    return sum(int(picture[24, bit * 4 + 2] > 128) << bit for bit in range(BITS))


@contextmanager
def mjpeg_server(*rounds, pause_s=0.0, login="", picture=jpeg_picture):
    """Serve a number of pictures (None: no end) to the first caller, and so on; then refuse.

    A negative number refuses its caller. With a login (``user:password``) others are refused.
    """
    left = list(rounds)
    closing = threading.Event()
    basic = "Basic " + base64.b64encode(login.encode()).decode()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            if login and self.headers.get("Authorization") != basic:
                self.send_response(401)
                self.send_header("WWW-Authenticate", 'Basic realm="camera"')
                self.end_headers()
                return
            count = left.pop(0) if left else -1
            if count is not None and count < 0:
                self.send_error(503)
                return
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
            self.end_headers()
            number = 0
            while number != count and not closing.wait(pause_s):
                data = cv2.imencode(".jpg", picture(number))[1].tobytes()
                head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}\r\n\r\n"
                try:
                    self.wfile.write(head.encode() + data + b"\r\n")
                except OSError:  # the camera has seen enough
                    return
                number += 1

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/stream"
    finally:
        closing.set()
        server.shutdown()
        server.server_close()
        thread.join()
