#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""view_drop.py WINDOW FILE...: drops files onto a window, like a file manager (XDND, version 5). Exits with
77 without libX11, and with 1 if the window rejects the file."""
import ctypes
import ctypes.util
import os
import sys
import urllib.parse

CLIENT_MESSAGE, SELECTION_NOTIFY, SELECTION_REQUEST, CURRENT_TIME, REPLACE = 33, 31, 30, 0, 0
ULONG, LONG, INT, POINTER = ctypes.c_ulong, ctypes.c_long, ctypes.c_int, ctypes.c_void_p


class ClientMessage(ctypes.Structure):
    _fields_ = [("type", INT), ("serial", ULONG), ("send_event", INT), ("display", POINTER), ("window", ULONG),
                ("message_type", ULONG), ("format", INT), ("data", LONG * 5)]


class SelectionRequest(ctypes.Structure):
    _fields_ = [("type", INT), ("serial", ULONG), ("send_event", INT), ("display", POINTER), ("owner", ULONG),
                ("requestor", ULONG), ("selection", ULONG), ("target", ULONG), ("property", ULONG), ("time", ULONG)]


class Selection(ctypes.Structure):
    _fields_ = [("type", INT), ("serial", ULONG), ("send_event", INT), ("display", POINTER), ("requestor", ULONG),
                ("selection", ULONG), ("target", ULONG), ("property", ULONG), ("time", ULONG)]


class Event(ctypes.Union):
    _fields_ = [("type", INT), ("message", ClientMessage), ("request", SelectionRequest), ("selection", Selection),
                ("pad", LONG * 24)]


def load():
    name = ctypes.util.find_library("X11")
    if name is None:
        sys.exit(77)
    x = ctypes.CDLL(name)
    x.XOpenDisplay.restype = POINTER
    x.XOpenDisplay.argtypes = [ctypes.c_char_p]
    x.XDefaultRootWindow.restype = ULONG
    x.XDefaultRootWindow.argtypes = [POINTER]
    x.XInternAtom.restype = ULONG
    x.XInternAtom.argtypes = [POINTER, ctypes.c_char_p, INT]
    x.XCreateSimpleWindow.restype = ULONG
    x.XCreateSimpleWindow.argtypes = [POINTER, ULONG] + 6 * [INT] + [ULONG]
    x.XSetSelectionOwner.argtypes = [POINTER, ULONG, ULONG, ULONG]
    x.XSendEvent.argtypes = [POINTER, ULONG, INT, LONG, ctypes.POINTER(Event)]
    x.XNextEvent.argtypes = [POINTER, ctypes.POINTER(Event)]
    x.XChangeProperty.argtypes = [POINTER, ULONG, ULONG, ULONG, INT, INT, ctypes.c_char_p, INT]
    x.XFlush.argtypes = [POINTER]
    return x


def main():
    window, paths = int(sys.argv[1]), [os.path.abspath(path) for path in sys.argv[2:]]
    x = load()
    display = x.XOpenDisplay(None)
    if not display:
        sys.exit("there is no display")
    atom = {name: x.XInternAtom(display, name.encode(), 0) for name in
            ("XdndEnter", "XdndPosition", "XdndStatus", "XdndDrop", "XdndFinished", "XdndSelection", "XdndActionCopy",
             "text/uri-list")}
    own = x.XCreateSimpleWindow(display, x.XDefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0)
    x.XSetSelectionOwner(display, atom["XdndSelection"], own, CURRENT_TIME)

    def send(name, *data):
        event = Event(message=ClientMessage(CLIENT_MESSAGE, 0, 1, display, window, atom[name], 32,
                                            (LONG * 5)(own, *data)))
        x.XSendEvent(display, window, 0, 0, ctypes.byref(event))
        x.XFlush(display)

    send("XdndEnter", 5 << 24, atom["text/uri-list"], 0, 0)
    send("XdndPosition", 0, 50 << 16 | 50, CURRENT_TIME, atom["XdndActionCopy"])
    event = Event()
    while True:
        x.XNextEvent(display, ctypes.byref(event))
        message, request = event.message, event.request
        if event.type == CLIENT_MESSAGE and message.message_type == atom["XdndStatus"]:
            if not message.data[1] & 1:
                sys.exit("the window takes no files")
            send("XdndDrop", 0, CURRENT_TIME, 0, 0)
        elif event.type == SELECTION_REQUEST:
            text = "".join("file://" + urllib.parse.quote(path) + "\r\n" for path in paths).encode()
            requestor, kept = request.requestor, request.property
            x.XChangeProperty(display, requestor, kept, request.target, 8, REPLACE, text, len(text))
            answer = Event(selection=Selection(SELECTION_NOTIFY, 0, 1, display, requestor, request.selection,
                                               request.target, kept, request.time))
            x.XSendEvent(display, requestor, 0, 0, ctypes.byref(answer))
            x.XFlush(display)
        elif event.type == CLIENT_MESSAGE and message.message_type == atom["XdndFinished"]:
            return


main()
