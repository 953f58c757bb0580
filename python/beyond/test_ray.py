"""A recipe over a Ray dataset, on two nodes, of which one loses a worker in the middle."""

import filecmp
import os
import threading
import time

import psutil
import pytest
import ray
import ray.data
from PIL import Image
from ray.cluster_utils import Cluster

import plenoscope
import plenoscope.ray

PHOTOS = 16


@pytest.fixture(scope="module")
def cluster():
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    cluster.add_node(num_cpus=1)
    ray.init(address=cluster.address, log_to_driver=False)
    ray.data.DataContext.get_current().enable_progress_bars = False
    yield cluster
    ray.shutdown()
    cluster.shutdown()


@pytest.fixture(scope="module")
def photos(tmp_path_factory):
    folder = tmp_path_factory.mktemp("photos")
    pixels = Image.fromarray(plenoscope.refocus(plenoscope.sample(), f_number=28, size=(300, 200), long_side=90))
    for n in range(PHOTOS):
        pixels.rotate(n).save(folder / f"{n}.png")
    return folder


@pytest.fixture(scope="module")
def recipe():
    return plenoscope.Recipe({"version": 2, "lens": {"f_number": 1.8}})


def rows(photos, out):
    names = [path.name for path in sorted(photos.glob("*.png"))]
    return [{"path": os.fspath(photos / name), "output": os.fspath(out / name)} for name in names]


def kill_a_worker(out, killed):
    """Ends a process that works on photos, once there are some pictures."""
    while not killed:
        time.sleep(0.05)
        if len(os.listdir(out)) < 3:
            continue
        for process in psutil.process_iter(["name", "cmdline"]):
            if any("ray::MapBatches" in part for part in process.info["cmdline"] or []):
                process.kill()
                killed.append(process.pid)
                break


def test_every_photo_is_there_once_and_none_is_torn(cluster, photos, recipe, tmp_path):
    assert sum(node["Alive"] for node in ray.nodes()) == 2
    killed = []
    killer = threading.Thread(target=kill_a_worker, args=(tmp_path, killed), daemon=True)
    killer.start()
    given = rows(photos, tmp_path)
    dataset = ray.data.from_items(given, override_num_blocks=PHOTOS // 2)
    told = plenoscope.ray.refocus(dataset, recipe, photos=2, long_side=90, cache=False).take_all()
    killer.join(timeout=60)
    assert len(killed) == 1, "a worker was killed in the middle"
    assert sorted(row["path"] for row in told) == [row["path"] for row in given]
    assert {row["state"] for row in told} <= {"made", "skipped"} and not any(row["error"] for row in told)
    assert sorted(os.listdir(tmp_path)) == sorted(path.name for path in photos.glob("*.png")), "and nothing beside them"
    for row in given:
        Image.open(row["output"]).load()
        plenoscope.refocus(row["path"], recipe=recipe, output=tmp_path / "again.png", long_side=90, cache=False)
        assert filecmp.cmp(row["output"], tmp_path / "again.png", shallow=False), row


def test_a_bad_photo_is_a_sentence_and_the_others_go_on(cluster, photos, recipe, tmp_path):
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n no picture")
    given = [*rows(photos, tmp_path)[:2], {"path": os.fspath(tmp_path / "broken.png"), "output": os.fspath(tmp_path / "x.png")}]
    told = plenoscope.ray.refocus(ray.data.from_items(given), recipe, long_side=90).take_all()
    states = {os.path.basename(row["output"]): row["state"] for row in told}
    assert states.pop("x.png") == "failed" and set(states.values()) == {"made"}
    (error,) = [row["error"] for row in told if row["error"]]
    assert "broken.png" in error and " — " in error
    again = plenoscope.ray.refocus(ray.data.from_items(given[:2]), recipe, long_side=90).take_all()
    assert {row["state"] for row in again} == {"skipped"}
