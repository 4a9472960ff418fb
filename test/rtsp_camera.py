"""
An RTSP camera: GStreamer's server, for the system's Python (`/usr/bin/python3 rtsp_camera.py`).

It asks for user and password by digest, as IP cameras do, and prints its port once it listens.
Arguments: port (0: any free one), user, password.
"""

import sys

import gi

for library in ('Gst', 'GstRtsp', 'GstRtspServer'):
    gi.require_version(library, '1.0')
from gi.repository import GLib, Gst, GstRtsp, GstRtspServer  # noqa: E402

PIPELINE = (
    'videotestsrc is-live=true pattern=ball ! video/x-raw,format=I420,width=320,height=240,'
    'framerate=25/1 ! jpegenc ! rtpjpegpay name=pay0 pt=26'
)


def main():
    port, user, password = sys.argv[1:]
    Gst.init(None)
    server = GstRtspServer.RTSPServer(address='127.0.0.1', service=port)
    auth = GstRtspServer.RTSPAuth()
    auth.set_supported_methods(GstRtsp.RTSPAuthMethod.DIGEST)
    token = GstRtspServer.RTSPToken()
    token.set_string('media.factory.role', 'viewer')
    auth.add_digest(user, password, token)
    server.set_auth(auth)
    factory = GstRtspServer.RTSPMediaFactory(launch=PIPELINE, shared=True)
    factory.add_role_from_structure(
        Gst.Structure.from_string('viewer,media.factory.access=true,media.factory.construct=true')[
            0
        ]
    )
    server.get_mount_points().add_factory('/stream', factory)
    server.attach(None)
    print(server.get_bound_port(), flush=True)
    GLib.MainLoop().run()


if __name__ == '__main__':
    main()
