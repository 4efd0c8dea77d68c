"""An RTSP server of somebody else's (GStreamer's), for Debian's own Python: /usr/bin/python3.

    /usr/bin/python3 rtsp_server.py PORT PICTURES FPS

It serves the JPEG pictures of a pattern such as /tmp/%03d.jpg again and again, at /film, and says
`going` when it listens.
"""

import sys

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstRtspServer", "1.0")
from gi.repository import GLib, Gst, GstRtspServer  # noqa: E402


def main():
    port, pictures, fps = sys.argv[1:]
    Gst.init(None)
    server = GstRtspServer.RTSPServer(address="127.0.0.1", service=port)
    factory = GstRtspServer.RTSPMediaFactory(shared=True)
    factory.set_launch(
        f"( multifilesrc location={pictures} loop=true do-timestamp=true caps=image/jpeg "
        f"! identity sleep-time={1_000_000 // int(fps)} ! jpegparse ! rtpjpegpay name=pay0 pt=26 )"
    )
    server.get_mount_points().add_factory("/film", factory)
    assert server.attach(None), "the port is taken"
    print("going", flush=True)
    GLib.MainLoop().run()


if __name__ == "__main__":
    main()
