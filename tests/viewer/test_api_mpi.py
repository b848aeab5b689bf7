"""The viewer by several processes: its page is that of one, its pictures are those of cvol-mpi render, and all
processes end with it."""

import glob
import os
import shutil
import signal
import subprocess
import time
import unittest
import urllib.request

import viewer_client
from viewer_client import CVOL, Viewer, make_folder, read_png, run, write_floats

MPI = os.path.join(os.path.dirname(os.path.abspath(CVOL)), "cvol-mpi")
# For Open MPI: in a container, as root, with more processes than cores, without ssh.
SETTINGS = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_plm_rsh_agent": "sh",
            "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
DIMS = (40, 44, 60)
VIEWS = [  # and the largest difference from one process: tests/cli/test_mpi.sh
    ({"mode": "composite", "camera": {"azimuth": 30, "elevation": 20}}, 12),
    ({"mode": "composite", "transfer": "hot", "light": {"on": True}}, 12),
    ({"mode": "mip", "camera": {"azimuth": 120}}, 1),
    ({"mode": "xray", "camera": {"azimuth": 75, "elevation": 20}}, 1),
    ({"mode": "composite", "width": 90, "height": 64, "camera": {"azimuth": 200}}, 12),
]


def can_start():
    if not os.path.exists(MPI) or not shutil.which("mpirun"):
        return False
    os.environ.update(SETTINGS)
    return subprocess.run(["mpirun", "-n", "2", "true"], capture_output=True, timeout=60).returncode == 0


def samples():
    for z in range(DIMS[2]):
        for y in range(DIMS[1]):
            for x in range(DIMS[0]):
                r = ((x - 19) ** 2 + (y - 21) ** 2 + (0.7 * z - 20) ** 2) ** 0.5
                yield max(0, 18 - r) * (1 + 0.2 * ((x // 4 + y // 4 + z // 4) % 2))


def read_page(viewer):
    with urllib.request.urlopen(viewer.address, timeout=60) as answer:
        page = answer.read()
    assert b"<canvas" in page, page[:200]
    return page


def processes_in(folder):
    found = []
    for link in glob.glob("/proc/[0-9]*/cwd"):
        try:
            name = os.readlink(os.path.join(os.path.dirname(link), "exe"))
            if os.readlink(link) == os.path.realpath(folder) and os.path.basename(name) == "cvol-mpi":
                found.append(int(link.split("/")[2]))
        except OSError:
            pass
    return found


@unittest.skipUnless(can_start(), "no cvol-mpi, or mpirun cannot start processes here")
class SeveralProcesses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = make_folder()
        name = cls.folder.name
        write_floats(os.path.join(name, "a.raw"), samples())
        run(name, "cvol compress a.raw a.cvol --dims 40x44x60 --type float32 --psnr 60")
        run(name, "cvol compress a.raw b.cvol --dims 40x44x60 --type float32 --psnr 40")
        cls.program = os.path.join(name, "cvol-many")
        with open(cls.program, "w") as file:
            file.write(f'#!/bin/sh\nexec mpirun -n 3 {MPI} "$@"\n')
        os.chmod(cls.program, 0o755)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def viewer(self, program):
        viewer_client.CVOL = program
        try:
            return Viewer(self.folder.name, "a.cvol", "b.cvol")
        finally:
            viewer_client.CVOL = CVOL

    def expect_near(self, a, b, most):
        self.assertEqual((a.width, a.height), (b.width, b.height))
        self.assertLessEqual(max(abs(p - q) for p, q in zip(a.rgb, b.rgb)), most)
        self.assertGreater(max(a.rgb), 50)

    def test_pictures(self):
        name = self.folder.name
        with self.viewer(CVOL) as one, self.viewer(self.program) as many:
            self.assertEqual(len(processes_in(name)), 3)
            self.assertEqual(read_page(one), read_page(many))
            for view, most in VIEWS:
                for volume in "01":
                    view = {"width": 80, "height": 72, **view, "volume": volume}
                    picture = many.frame(**view)
                    self.expect_near(picture, one.frame(**view), most)
            command = many.post("command", {"view": view}).json["command"]
            run(name, command.replace("cvol render", self.program + " render"))
            with open(os.path.join(name, command.split(" -o ")[1].split()[0]), "rb") as file:
                self.assertEqual(read_png(file.read()), picture)
            failed = many.post("frame", {"view": {"volume": "7"}})
            self.assertEqual(failed.status, 404)
        for _ in range(100):
            if not processes_in(name):
                break
            time.sleep(0.1)
        self.assertEqual(processes_in(name), [])

    def test_damage(self):
        """A file that the other processes cannot read any more: an error, and the viewer goes on."""
        name = self.folder.name
        shutil.copy(os.path.join(name, "b.cvol"), os.path.join(name, "b.copy"))
        with self.viewer(self.program) as many:
            os.remove(os.path.join(name, "b.cvol"))
            try:
                answer = many.post("frame", {"view": {"volume": "1", "width": 40, "height": 40}})
            finally:
                os.rename(os.path.join(name, "b.copy"), os.path.join(name, "b.cvol"))
            self.assertEqual(answer.status, 500)
            self.assertIn("b.cvol: No such file", answer.error)
            many.frame(volume="1", width=40, height=40)

    def test_end(self):
        """Process 0 alone gets the signal: all end, with status 0."""
        with self.viewer(self.program) as many:
            for process in processes_in(self.folder.name):
                with open(f"/proc/{process}/environ", "rb") as file:
                    variables = file.read().split(b"\0")
                if {b"OMPI_COMM_WORLD_RANK=0", b"PMI_RANK=0"} & set(variables):
                    os.kill(process, signal.SIGINT)
            many.process.wait(30)
            self.assertEqual(many.process.returncode, 0)


if __name__ == "__main__":
    unittest.main()
