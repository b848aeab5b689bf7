"""Clients without the token: they cannot occupy connections that others need, and never receive the token."""

import contextlib
import os
import pathlib
import signal
import socket
import subprocess
import time
import unittest
import urllib.request

from viewer_client import CVOL
from viewer_strict import Folder, Viewer

folder = None
shared = None  # the viewer that most tests use


def setUpModule():
    global folder, shared
    folder = Folder()
    try:
        shared = Viewer(folder.volume("a"))
        assert shared.wait("0")["state"] == "ready"
    except BaseException:
        folder.remove()
        raise


def tearDownModule():
    try:
        status = shared.end()
        assert status == 0, f"status {status}: {shared.stderr()}"
    finally:
        folder.remove()


class Strangers(unittest.TestCase):
    def test_clients_without_token_do_not_occupy_connections(self):
        silent = []
        try:
            for i in range(200):
                s = socket.create_connection((shared.host, shared.port), timeout=60)
                silent.append(s)
                if i % 3 == 1:
                    s.sendall(b"GET /")
                if i % 3 == 2:
                    s.sendall(b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000\r\n\r\n")
            begin = time.monotonic()
            self.assertEqual(shared.get("api/1").status, 200)
            self.assertLess(time.monotonic() - begin, 10, "a client with the token must not wait")
            for s in silent:
                s.settimeout(max(0.01, begin + 10 - time.monotonic()))
                with contextlib.suppress(ConnectionResetError):
                    while s.recv(4096):
                        pass
        finally:
            for s in silent:
                s.close()

    def test_connections_without_token_are_closed_within_five_seconds(self):
        begin = time.monotonic()
        with socket.create_connection((shared.host, shared.port), timeout=30) as s:
            with contextlib.suppress(OSError):
                for letter in f"GET {shared.root} HTTP/1.1" * 9:
                    s.sendall(letter.encode())
                    time.sleep(0.1)
                    if time.monotonic() - begin > 15:
                        break
            self.assertLess(time.monotonic() - begin, 8)  # allows for a busy machine
        with socket.create_connection((shared.host, shared.port), timeout=30) as s:
            s.sendall(b"GET /no/token HTTP/1.1\r\nHost: localhost\r\n\r\n")
            text = b""
            while more := s.recv(4096):
                text += more
            self.assertIn(b"connection: close", text.lower())

    def test_browsers_may_only_navigate_to_the_page(self):
        navigation = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}
        self.assertEqual(shared.get("", headers=navigation).status, 200)  # navigation to the page, for example by a link
        self.assertEqual(403, shared.get("api/1", headers=navigation).status)
        self.assertEqual(403, shared.get("", headers=navigation | {"Sec-Fetch-Dest": "iframe"}).status)

    def test_arguments_of_the_browser_do_not_contain_the_token(self):
        place = pathlib.Path(folder / "open")
        os.makedirs(place / "bin")
        os.makedirs(place / "tmp")
        (place / "bin/xdg-open").write_text(
            '#!/bin/sh\n(echo "$*"; stat -c "%a" "$1" "${1%/*}"; cat "$1") >opened.new; mv opened.new opened\n')
        (place / "bin/xdg-open").chmod(0o755)
        environment = dict(os.environ, DISPLAY=":0", TMPDIR=str(place / "tmp"), PATH=f"{place / 'bin'}:{os.environ['PATH']}")
        process = subprocess.Popen([CVOL, "view", folder / "a.cvol"], cwd=place, env=environment,
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        try:
            address = process.stdout.readline().decode().strip()
            token = address.split("/")[3]
            for _ in range(600):
                if (place / "opened").exists():
                    break
                time.sleep(0.1)
            arguments, mode, folder_mode, page = (place / "opened").read_text().split("\n", 3)
            self.assertEqual(len(token), 32)
            self.assertNotIn(token, arguments)
            self.assertEqual((mode, folder_mode), ("600", "700"))
            self.assertIn(f"url={address}", page)
            # Browsers treat the temporary page as another site.
            navigation = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}
            ask = urllib.request.Request(address, headers=navigation)
            self.assertEqual(urllib.request.urlopen(ask, timeout=60).status, 200)
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(60)
            process.stdout.close()
        self.assertEqual(os.listdir(place / "tmp"), [])


if __name__ == "__main__":
    unittest.main()
