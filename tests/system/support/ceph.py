"""A real Ceph cluster on loopback: one monitor, some OSDs, no authentication, a pool `tiles`."""

import json
import pathlib
import shutil
import signal
import socket
import subprocess
import time
import uuid

TOOLS = ["ceph", "ceph-mon", "ceph-osd", "ceph-authtool", "monmaptool"]
PATIENCE = 60
POOL = "tiles"

SETTINGS = """
[global]
fsid = {fsid}
mon_host = [v2:{address}:{port}/0]
public_addr = {address}
cluster_addr = {address}
ms_bind_msgr1 = false
auth_cluster_required = none
auth_service_required = none
auth_client_required = none
mon_allow_pool_size_one = true
mon_data = {folder}/mon.$id
osd_data = {folder}/osd.$id
run_dir = {folder}/run
admin_socket = {folder}/run/$name.asok
log_file = {folder}/log/$name.log
pid_file = {folder}/run/$name.pid
keyring = {folder}/keyring
crash_dir = {folder}/crash
osd_objectstore = bluestore
osd_crush_chooseleaf_type = 0
osd_pool_default_size = {osds}
osd_pool_default_min_size = {least}
osd_pool_default_pg_autoscale_mode = off
bluestore_block_size = 8589934592
bluestore_cache_size = 67108864
osd_memory_target = 939524096
osd_op_num_shards = 2
osd_op_num_threads_per_shard = 1
osd_heartbeat_interval = 1
osd_heartbeat_grace = 4
mon_osd_min_down_reporters = 1
mon_osd_down_out_interval = 600
mon_osd_adjust_heartbeat_grace = false
mon_osd_full_ratio = .99
mon_osd_nearfull_ratio = .97
mon_osd_backfillfull_ratio = .98
mon_data_avail_crit = 1
mon_data_avail_warn = 2
setuser_match_path = {folder}/nothing
"""


def missing():
    """Why there can be no cluster here, in words; empty where there can."""
    absent = [tool for tool in TOOLS if not shutil.which(tool)]
    return "not installed (scripts/setup --rados): " + ", ".join(absent) if absent else ""


def free_port(address):
    with socket.socket() as probe:
        probe.bind((address, 0))
        return probe.getsockname()[1]


class Cluster:
    """`conf` is what clients read. All daemons end with stop()."""

    def __init__(self, folder, osds=3, address="127.0.0.1"):
        self.folder = pathlib.Path(folder)
        self.conf = self.folder / "ceph.conf"
        self.osds = osds
        self.address = address
        self.daemons = {}  # Name to process.

    def start(self):
        for part in ("run", "log", "crash", "mon.a"):
            (self.folder / part).mkdir(parents=True)
        fsid, port = uuid.uuid4(), free_port(self.address)
        self.conf.write_text(SETTINGS.format(fsid=fsid, port=port, address=self.address,
                                             folder=self.folder,
                                             osds=self.osds, least=2 if self.osds > 2 else 1))
        keyring, monmap = self.folder / "keyring", self.folder / "monmap"
        self._run("ceph-authtool", "-C", keyring, "--gen-key", "-n", "mon.", "--cap", "mon",
                  "allow *")
        self._run("ceph-authtool", keyring, "--gen-key", "-n", "client.admin", "--cap", "mon",
                  "allow *", "--cap", "osd", "allow *")
        self._run("monmaptool", "--create", "--fsid", fsid, "--addv", "a",
                  f"[v2:{self.address}:{port}/0]", monmap)
        self._run("ceph-mon", "-c", self.conf, "--mkfs", "-i", "a", "--monmap", monmap,
                  "--keyring", keyring)
        self.start_daemon("mon.a")
        for number in range(self.osds):
            self._make_osd(number)
            self.start_daemon(f"osd.{number}")
        self.wait_until_up(self.osds)
        self.ceph("osd", "pool", "create", POOL, "16", "16", "replicated")

    def _make_osd(self, number):
        (self.folder / f"osd.{number}").mkdir()
        osd_id = str(uuid.uuid4())
        self.ceph("osd", "new", osd_id, str(number))
        self._run("ceph-osd", "-c", self.conf, "-i", number, "--mkfs", "--osd-uuid", osd_id)
        self.ceph("osd", "crush", "add", f"osd.{number}", "1.0", "root=default", "host=localhost")

    def start_daemon(self, name):
        kind, number = name.split(".")
        with open(self.folder / "log" / f"{name}.out", "ab") as log:
            self.daemons[name] = subprocess.Popen(
                [f"ceph-{kind}", "-f", "-c", self.conf, "-i", number], stdin=subprocess.DEVNULL,
                stdout=log, stderr=log)

    def kill(self, name):
        self.daemons[name].kill()
        self.daemons[name].wait()

    def revive(self, *names):
        for name in names:
            self.start_daemon(name)
        self.wait_until_up(self.osds)

    def slow_down(self, slow):
        """Whether each OSD waits 30 ms before each message it handles. Were it 0.1 s, the messages
        by which replicas prolong their read leases would take longer than the leases last."""
        for number in range(self.osds):
            for name, value in (("duration", "0.03"), ("probability", "1" if slow else "0")):
                self.ceph("tell", f"osd.{number}", "config", "set",
                          f"osd_debug_inject_dispatch_delay_{name}", value)

    def set_full(self, full):
        """Whether the cluster calls its disks full, however empty they are."""
        ratios = [("nearfull", 1e-7, .97), ("backfillfull", 2e-7, .98), ("full", 3e-7, .99)]
        for name, low, normal in ratios if full else reversed(ratios):
            self.ceph("osd", f"set-{name}-ratio", str(low if full else normal))

    def objects(self, model, prefix):
        """Names of a model's objects that begin so."""
        listed = self._run("rados", "-c", self.conf, "-p", POOL, "-N", model, "ls")
        return [name for name in listed.splitlines() if name.startswith(prefix)]

    def tiles(self, model):
        """How many rows the first region of a model that has any holds, or a few more: keys are
        bytes, some of them line feeds."""
        for region in self.objects(model, "region-"):
            rows = self._run("rados", "-c", self.conf, "-p", POOL, "-N", model, "listomapkeys", region)
            if rows:
                return len(rows.splitlines())
        return 0

    def store(self, model):
        """What --store takes."""
        return f"rados:{self.conf},{POOL},{model}"

    def wait_until_up(self, osds):
        end = time.monotonic() + PATIENCE
        while json.loads(self.ceph("osd", "stat", "-f", "json"))["num_up_osds"] != osds:
            if time.monotonic() > end:
                raise AssertionError(f"{osds} OSDs were not up within {PATIENCE} s")
            time.sleep(0.2)

    def ceph(self, *arguments):
        return self._run("ceph", "-c", self.conf, "--connect-timeout", PATIENCE, *arguments)

    @staticmethod
    def _run(*command):
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True,
                              errors="replace", check=False, stdin=subprocess.DEVNULL)
        if done.returncode != 0:
            raise AssertionError(f"{command}: {done.stderr}")
        return done.stdout

    def stop(self):
        for process in self.daemons.values():
            process.send_signal(signal.SIGCONT)
            process.kill()
        for process in self.daemons.values():
            process.wait()
        self.daemons = {}
