import dataclasses as dc
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from learning_scenes import FAST

from vh_drake.errors import BadInput
from vh_drake.learning.dataset import (
    DatasetSpec,
    dask_executor,
    generate,
    info,
    make_spec,
    read_scenes,
    shard_name,
    verify,
)
from vh_drake.learning.training_objects import VALIDATION_KINDS

SPEC = DatasetSpec(
    scenes=4,
    objects=("can", "fruit_drink"),
    scenes_per_shard=1,
    settings=dc.replace(FAST, candidates=6),
)
TESTS = str(Path(__file__).parents[1])
CODE = (
    "import sys; sys.path[:0] = [sys.argv[2], sys.argv[2] + '/learning']\n"
    "from pathlib import Path; from test_dataset import *\n"
    "if __name__ == '__main__':\n"
    "    generate(Path(sys.argv[1]), SPEC, workers=1)\n"
)


def contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.*"))}


def kill_midway(process, folder):
    """Kills a process once the first shard of a folder is there."""
    until = time.monotonic() + 120
    while not list(folder.glob("scenes-*.parquet")) and time.monotonic() < until:
        time.sleep(0.01)
    os.kill(process, signal.SIGKILL)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    generate(folder, SPEC, workers=1)
    return folder


@pytest.mark.slow
def test_killed_at_random_moments_it_ends_with_the_same_bytes(whole, tmp_path):
    command = [sys.executable, "-c", CODE, str(tmp_path), TESTS]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(command, env=environment)
    until = time.monotonic() + 120
    while not (tmp_path / shard_name(1)).is_file() and time.monotonic() < until:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    (tmp_path / ".scenes-00003.parquet.cut").write_bytes(b"half a shard")
    assert not (tmp_path / "checksums.json").is_file()
    generate(tmp_path, SPEC, workers=1)
    assert contents(tmp_path) == contents(whole)
    assert not list(tmp_path.glob(".scenes*"))


@pytest.mark.slow
def test_two_workers_give_the_same_bytes(whole, tmp_path):
    generate(tmp_path, SPEC, workers=2)
    assert contents(tmp_path) == contents(whole)


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_bytes_though_one_worker_is_killed(whole, tmp_path):
    from distributed import LocalCluster

    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
        ) as cluster,
        dask_executor(cluster.scheduler_address) as executor,
    ):
        worker = executor.submit(os.getpid).result()
        killer = threading.Thread(target=kill_midway, args=(worker, tmp_path))
        killer.start()
        generate(tmp_path, SPEC, executor=executor)
        killer.join()
    assert contents(tmp_path) == contents(whole)


def test_a_whole_data_set_is_verified_and_described(whole):
    assert verify(whole) == []
    told = info(whole)
    assert told["scenes"] == told["scenes_wanted"] == 4
    assert told["objects"] == 2
    assert told["candidates"] == sum(len(s.candidates) for s in read_scenes(whole))
    assert sum(told["scenes_by_contacts"]) == 4
    assert 0 < told["success_share"] < 1


def test_verification_names_what_is_damaged_missing_or_unfinished(whole, tmp_path):
    for path in whole.glob("*.*"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    cut = tmp_path / shard_name(0)
    cut.write_bytes(cut.read_bytes()[:-20])
    (tmp_path / shard_name(2)).unlink()
    problems = " ".join(verify(tmp_path))
    assert "cannot be read" in problems
    assert "SHA-256" in problems
    assert f"{shard_name(2)} is missing" in problems
    (tmp_path / "checksums.json").unlink()
    assert any("not finished" in problem for problem in verify(tmp_path))


def test_a_folder_of_another_data_set_is_refused(whole):
    with pytest.raises(BadInput, match="other settings"):
        generate(whole, dc.replace(SPEC, seed=1))


def test_a_folder_without_a_data_set_is_refused(tmp_path):
    for function in (info, verify):
        with pytest.raises(BadInput, match="dataset generate"):
            function(tmp_path)


def test_objects_of_the_test_split_and_of_table_4_6_are_never_learnt_from(tmp_path):
    for name in ("one", "two"):
        (tmp_path / f"{name}.obj").write_text("v 0 0 0\n")
    (tmp_path / "objects.csv").write_text("name,split\none,train\ntwo,test\n")
    names = make_spec(10, folder=tmp_path, shapes=8).objects
    assert "one" in names
    assert "two" not in names
    assert not VALIDATION_KINDS & set(names)
    assert sum(name.startswith("shape_") for name in names) == 8


def test_every_object_has_its_turn_before_one_comes_again():
    spec = make_spec(200, shapes=20)
    count = len(spec.objects)
    first = {spec.object_of(i) for i in range(count)}
    assert first == set(spec.objects)
    assert [spec.object_of(i) for i in range(count)] != sorted(first)


def test_unusable_wishes_are_refused():
    with pytest.raises(BadInput, match="scenes"):
        make_spec(0)
    with pytest.raises(BadInput, match="no object"):
        make_spec(5, shapes=0, library=False)
    with (
        pytest.raises(BadInput, match="no Dask scheduler"),
        dask_executor("tcp://127.0.0.1:9"),
    ):
        pass
