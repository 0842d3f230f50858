"""How a run in step with the wall clock is written down; about 6 s."""

import pytest

import fesloop
from fesloop.experiment import running
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.recording.writing import RecordingWriter
from fesloop.loop.machine import InStep

pytestmark = pytest.mark.realtime

NAME = "finger_pid_latency"
SHORT = ["experiment.duration_s=1.2"]


@pytest.mark.slow
def test_it_is_written_stream_by_stream_and_is_the_same(tmp_path, monkeypatch):
    together, append = [], RecordingWriter._append

    def noted(self, tables):
        together.append(len(tables))
        append(self, tables)

    experiment = fesloop.load(NAME, SHORT)
    plain = experiment.run(tmp_path)
    monkeypatch.setattr(RecordingWriter, "_append", noted)
    paced = experiment.run(tmp_path, realtime=True)
    with Recording(paced.recording) as one, Recording(plain.recording) as other:
        assert one.digest() == other.digest()
        assert one.instants["time_ns"].tolist() == [k * 10_000_000 for k in range(120)]
    assert together.count(1) >= len(experiment.nodes)


def test_a_disk_that_fills_up_between_two_pieces_ends_the_run(tmp_path, monkeypatch):
    appended, append = [], RecordingWriter._append

    def counted(self, tables):
        appended.append(len(tables))
        append(self, tables)

    monkeypatch.setattr(RecordingWriter, "_append", counted)
    monkeypatch.setattr("fesloop.experiment.recording.writing.free_bytes",
                        lambda path: 10**12 if len(appended) < 4 else 10**6)
    result = running.run(fesloop.load(NAME, SHORT), tmp_path, realtime=True)
    assert result.status == "failed"
    assert "the disk is full" in result.cause
    with Recording(result.recording) as recording:
        assert recording.status == "failed"


@pytest.mark.slow
def test_when_a_trial_began_stands_in_the_file_from_its_first_instant_on(tmp_path, monkeypatch):
    seen, advance = [], InStep.advance

    def looked(self, stop_ns):
        done = advance(self, stop_ns)
        if not seen:
            with Recording(next(tmp_path.glob("[!.]*.h5"))) as recording:
                seen.append(recording.origins["monotonic_ns"].tolist())
        return done

    monkeypatch.setattr(InStep, "advance", looked)
    result = fesloop.load(NAME, SHORT).run(tmp_path, realtime=True)
    with Recording(result.recording) as recording:
        assert seen == [recording.origins["monotonic_ns"].tolist()]
        assert len(seen[0]) == 1
