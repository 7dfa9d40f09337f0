"""HTTP/2 by hand (RFC 9113), for more calls than a library makes: requests of one message, and how they ended."""
import socket
import struct
import threading

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
DATA, HEADERS, RST_STREAM, SETTINGS, PING, GOAWAY = 0, 1, 3, 4, 6, 7
END_STREAM, END_HEADERS, ACK = 1, 4, 1
# Identifiers of streams are odd.
LAST_STREAM = 2**31 - 1


def frame(kind, flags, stream, payload=b""):
    return struct.pack(">I", len(payload))[1:] + struct.pack(">BBI", kind, flags, stream) + payload


def block(path):
    """The header of a call, without compression (RFC 7541, 6.2.2)."""
    fields = {
        ":method": "POST",
        ":scheme": "http",
        ":path": path,
        ":authority": "localhost",
        "content-type": "application/grpc",
        "te": "trailers",
    }
    out = b""
    for name, value in fields.items():
        # Their lengths are one byte.
        out += b"\0" + b"".join(bytes([len(text)]) + text.encode() for text in (name, value))
    return out


class Connection:
    """Calls of one path on one connection, of at most so many that are open at one time."""

    def __init__(self, address, path, most):
        kind, place = socket.AF_UNIX, address.removeprefix("unix:")
        if not address.startswith("unix:"):
            host, port = address.rsplit(":", 1)
            kind, place = socket.AF_INET, (host, int(port))
        self.socket = socket.socket(kind, socket.SOCK_STREAM)
        self.socket.connect(place)
        self.header, self.next, self.begun, self.ended = block(path), 1, 0, 0
        self.room, self.gone, self.writing = threading.Semaphore(most), False, threading.Lock()
        self.write(PREFACE + frame(SETTINGS, 0, 0))
        threading.Thread(target=self.read, daemon=True).start()

    def write(self, data):
        with self.writing:
            try:
                self.socket.sendall(data)
            except OSError:
                self.gone = True

    def call(self, count=1, message=bytes(5)):
        """Begins so many calls, when there is room for them; `message` has its prefix."""
        out = []
        for _ in range(count):
            while not self.room.acquire(timeout=1):
                if self.gone:
                    return
            stream, self.next, self.begun = self.next, self.next + 2, self.begun + 1
            out += [frame(HEADERS, END_HEADERS, stream, self.header), frame(DATA, END_STREAM, stream, message)]
        self.gone |= self.next > LAST_STREAM
        self.write(b"".join(out))

    def read(self):
        """Counts calls that end, and answers for the connection itself."""
        kept = b""
        while not self.gone:
            try:
                more = self.socket.recv(1 << 18)
            except OSError:
                more = b""
            if not more:
                break
            kept, at = kept + more, 0
            while len(kept) >= at + 9 and len(kept) >= at + 9 + int.from_bytes(kept[at : at + 3], "big"):
                end = at + 9 + int.from_bytes(kept[at : at + 3], "big")
                self.take(kept[at + 3], kept[at + 4], kept[at + 9 : end])
                at = end
            kept = kept[at:]
        self.gone = True

    def take(self, kind, flags, payload):
        if kind in (SETTINGS, PING) and not flags & ACK:
            self.write(frame(kind, ACK, 0, payload if kind == PING else b""))
        elif kind == RST_STREAM or (kind in (DATA, HEADERS) and flags & END_STREAM):
            self.ended += 1
            self.room.release()
        elif kind == GOAWAY:
            self.gone = True

    def close(self):
        self.gone = True
        self.socket.close()
