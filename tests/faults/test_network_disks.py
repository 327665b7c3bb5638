"""A fill on a network disk begins with a warning; the type of the disk is that of its mount point."""

import subprocess
from pathlib import Path

import pytest

from orbitdb.store import paths
from orbitdb.store.paths import NETWORK_DISKS, disk_type, network_disk

MOUNTS = """\
/dev/sda1 / ext4 rw 0 0
proc /proc proc rw 0 0
server:/home /home nfs4 rw,vers=4.2 0 0
/dev/sdb1 /home/me/fast xfs rw 0 0
//nas/share /mnt/my\\040share cifs rw 0 0
tmpfs /scratch tmpfs rw 0 0
mgs@tcp:/lfs /scratch lustre rw 0 0
me@host: /home/me/fast/remote fuse.sshfs rw 0 0
"""


@pytest.mark.parametrize(
    ("path", "kind"),
    [("/data/orbits.db", "ext4"), ("/home/me/orbits.db", "nfs4"), ("/home/me/fast/orbits.db", "xfs"),
     ("/home/me/faster/orbits.db", "nfs4"), ("/homes/orbits.db", "ext4"), ("/mnt/my share/x.db", "cifs"),
     ("/mnt/my/x.db", "ext4"), ("/scratch/x.db", "lustre"), ("/home/me/fast/remote/x.db", "fuse.sshfs")],
)  # fmt: skip
def test_the_longest_mount_point_says_what_disk_it_is(path, kind):
    assert disk_type(Path(path), MOUNTS) == kind
    assert disk_type(Path(path), "") is None
    assert (kind in NETWORK_DISKS) == (kind not in ("ext4", "xfs"))


def test_the_type_is_that_of_the_system(tmp_path):
    asked = ["findmnt", "-n", "-o", "FSTYPE", "-T", str(tmp_path)]
    try:
        found = subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("needs findmnt")
    assert disk_type(tmp_path, Path("/proc/mounts").read_text()) == found
    assert network_disk(tmp_path) == (found if found in NETWORK_DISKS else None)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["fill --p 3", "sweep --p 3", "births --p 3"])
def test_work_on_a_network_disk_begins_with_a_warning(cli, tmp_path, monkeypatch, command):
    """Every disk of this machine is declared to be one of a network."""
    usual = cli(*command.split()).err
    kind = disk_type(tmp_path, Path("/proc/mounts").read_text()) or pytest.skip("no mount points")
    monkeypatch.setattr(paths, "NETWORK_DISKS", {kind})
    outcome = cli(*command.split())
    assert outcome.code == 0
    first, *others = outcome.err.splitlines()
    assert f"orbits.db is on a network disk ({kind})" in first
    assert "copy the file afterwards" in first
    assert len(others) == len(usual.splitlines())
    assert "network disk" not in usual + cli("query", "--p", "3").err
