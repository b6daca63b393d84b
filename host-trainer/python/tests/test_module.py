"""The module as a user of Python has it: arrays, dictionaries, exceptions, interrupts, tables, estimators."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import ballrace

RIG = (Path(__file__).parents[2] / "src" / "cli" / "demo" / "rig.toml").read_text()
SDOF = 'kind = "sdof"\nmass_kg = 2.0\ndamping_n_s_per_m = 4.0\nstiffness_n_per_m = 800.0\ninput_gain_n_per_unit = 3.0\n'


def tones(count=8000, seed=0):
    """Two tones and noise, m/s²."""
    t = np.arange(count)
    return np.sin(0.3 * t) + 0.2 * np.sin(1.1 * t) + 0.01 * np.random.default_rng(seed).standard_normal(count)


def recordings(count=3):
    return [ballrace.Recording({"ay": tones(seed=n)}, 25600.0, name=f"r{n}") for n in range(count)]


def small(**more):
    return ballrace.fit(recordings(), solver="stlsq", dimension=3, degree=1, harmonics=0, null=0, **more)


def test_arrays_are_kept_and_not_copied():
    samples = tones()
    recording = ballrace.Recording({"ay": samples}, 25600.0)
    assert recording["ay"] is samples and recording.channels["ay"] is samples and len(recording) == len(samples)


def test_load_gives_what_a_file_holds_and_errors_name_the_place(tmp_path):
    samples = tones(1000)
    file = tmp_path / "r01.csv"
    np.savetxt(file, samples, header="ay", comments="")
    (found,) = ballrace.load(file, sample_rate_hz=25600.0, unit="m/s^2")
    assert found.name == "r01" and found.sample_rate_hz == 25600.0
    np.testing.assert_allclose(found["ay"], samples)
    file.write_text("ay\n1.0\nx\n2.0\n")
    with pytest.raises(ballrace.InputError, match=r"r01\.csv.*row 3.*found.*expected"):
        ballrace.load(file, sample_rate_hz=25600.0, unit="m/s^2")
    assert issubclass(ballrace.InputError, ValueError)
    with pytest.raises(ballrace.InputError, match=r"\[2\].*not finite"):
        ballrace.Recording({"ay": np.array([1.0, 2.0, np.nan])}, 25600.0)


def test_a_model_fits_predicts_saves_and_exports(tmp_path):
    model = small()
    trace = model.predict(tones(seed=9))
    assert trace["measured"].shape == trace["predicted"].shape == (len(trace["time_s"]), 3)
    model.save(tmp_path / "model.json")
    again = ballrace.Model.load(tmp_path / "model.json")
    assert again.export("bin") == model.export("bin") and again.report == model.report
    assert b"ballrace" in model.export("c").lower() and json.loads(model.export("json"))
    assert "R²" in model.text() and "<iframe" in model._repr_html_()
    with pytest.raises(ballrace.InputError, match="format: found `exe`"):
        model.export("exe")


def test_monitor_is_quiet_on_the_healthy_and_alarms_at_a_change():
    model = small()
    quiet = ballrace.monitor(model, recordings())
    assert quiet["summary"]["alarms"] == 0 and len(quiet["recordings"]) == 3
    changed = [ballrace.Recording({"ay": 3.0 * tones(seed=n) ** 3}, 25600.0, name=f"c{n}") for n in range(6)]
    assert ballrace.monitor(model, recordings() + changed)["summary"]["first_alarm"]["recording"].startswith("c")


def test_a_rig_simulates_and_its_diagnosis_names_friction():
    made = ballrace.Rig(RIG).simulate(25.0, 400.0, seconds=0.2)
    assert set(made.channels) >= {"ax", "ay"} and len(made) == 5120
    spectrum = ballrace.spectra(made)
    assert spectrum["recordings"][0]["sample_rate_hz"] == 25600.0 and "<html" in spectrum["page"].html

    rig = ballrace.Rig(SDOF)
    machine = ballrace.Rig(SDOF + '[[effect]]\nname = "coulomb-friction"\nforce_n = 0.5\n')
    t = np.arange(3000) / 500
    drive = [0.5 * sum(np.sin((2 + 3 * k + n) * t + k * k) for k in range(8)) for n in range(4)]
    drives = [ballrace.Recording({"u": u}, 500.0, name=f"r{n}") for n, u in enumerate(drive)]
    moved = [ballrace.Recording({"u": m["u"], "q": m["q"]}, 500.0, name=m.name) for m in machine.predict(drives)]
    found = ballrace.diagnose(rig, moved, seed=1)
    assert found.verdict == "mismatch" and found.causes[0]["name"] == "coulomb-friction"
    assert found.causes[0]["parameters"]["force_n"] == pytest.approx(0.5, rel=0.05)
    assert "coulomb-friction" in found.corrected_rig.to_toml() and "iframe" in found._repr_html_()
    assert ballrace.diagnose(rig, rig.predict(drives), seed=1).verdict == "no-mismatch"


@pytest.fixture
def interruptible():
    """Ctrl-C as a terminal's process has it: one that was started in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupt(*_):
    os.kill(os.getpid(), signal.SIGINT)


def test_other_threads_run_meanwhile_and_an_interrupt_ends_a_fit(interruptible):
    told, counted = [], []
    ended = threading.Event()

    def count():
        while len(counted) < 20 and not ended.is_set():
            if told:
                counted.append(len(told))
            time.sleep(0.01)
        if not ended.is_set():
            interrupt()

    other = threading.Thread(target=count)
    other.start()
    # The fit would take days: the other thread runs meanwhile, or nothing ends it.
    with pytest.raises(KeyboardInterrupt):
        ballrace.fit(recordings(), max_steps=10**9, progress=lambda done, text: told.append(done))
    ended.set()
    other.join()
    assert len(counted) == 20 and all(0 <= done < 1 for done in told)
    small()


@pytest.mark.parametrize("work", ["calibrate", "diagnose"])
def test_an_interrupt_ends_a_search_and_no_later_one(work, interruptible):
    """That it ends within its stage, host-trainer/tests/cancel.rs holds."""
    rig = ballrace.Rig('unknown = ["inner.stiffness_n_per_m", "outer.damping_n_s_per_m"]\n' + RIG)
    made = [rig.simulate(20.0 + n, 400.0, seconds=0.5, seed=n) for n in range(4)]
    with pytest.raises(KeyboardInterrupt):
        getattr(ballrace, work)(rig, made, progress=interrupt)
    assert len(rig.simulate(20.0, 400.0, seconds=0.1)) == 2560


def test_an_interrupted_sweep_has_not_run_to_its_end_and_goes_on(tmp_path, interruptible):
    grid = {"solver": "stlsq", "nd": 1, "nmd": 3, "nf": 0, "null": 1, "causal": False, "seed": list(range(20))}
    with pytest.raises(KeyboardInterrupt):
        ballrace.sweep(recordings(), out=tmp_path, progress=interrupt, **grid)
    journal = tmp_path / "rows.jsonl"
    before = journal.read_text().splitlines() if journal.exists() else []
    assert len(before) < 60
    assert len(ballrace.sweep(recordings(), out=tmp_path, **grid)) == 60
    after = journal.read_text().splitlines()
    assert len(after) == 60 and after[: len(before)] == before


def test_a_bar_of_tqdm_shows_progress_and_a_wrong_one_is_named(monkeypatch, capsys):
    pytest.importorskip("tqdm")
    small(progress=True)
    shown = capsys.readouterr().err
    assert "100% |" in shown and "left)" in shown
    rig = ballrace.Rig(SDOF)
    drive = [ballrace.Recording({"u": tones(3000, seed=n)}, 500.0, name=f"r{n}") for n in range(4)]
    moved = [ballrace.Recording({"u": m["u"], "q": m["q"]}, 500.0, name=m.name) for m in rig.predict(drive)]
    ballrace.diagnose(rig, moved, progress=True)
    assert small(progress=False) and "%" not in capsys.readouterr().err
    with pytest.raises(TypeError, match="progress: found str, expected True or a callable"):
        small(progress="yes")
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match=r"found no tqdm.*ballrace\[progress\]"):
        small(progress=True)


def test_an_exception_in_the_callback_ends_the_work():
    def refuse(_, text):
        raise RuntimeError(text)

    with pytest.raises(RuntimeError):
        ballrace.fit(recordings(), max_steps=10**9, progress=refuse)


def life(healthy=40, aging=20):
    """Recordings of a machine: normal noise, then with more and more impacts."""
    random = np.random.default_rng(0)
    out = []
    for n in range(healthy + aging):
        samples = random.standard_normal(4096)
        if n >= healthy:
            samples[random.integers(0, 4096, 12)] += 6.0 + 0.3 * (n - healthy)
        if n >= healthy + aging - 3:
            samples *= 4.0 ** (n - healthy - aging + 4)
        out.append(ballrace.Recording({"ay": samples}, 25600.0, name=f"r{n:03}"))
    return out


def test_phases_say_when_a_machine_began_to_age_and_to_fail():
    pd = pytest.importorskip("pandas")
    found = ballrace.phases(life())
    rows, features = pd.DataFrame(found["phases"]), pd.DataFrame(found["features"])
    raw = rows[~rows.denoised].iloc[0]
    assert (raw.channel, raw.healthy, raw.aging, raw.aging_name) == ("ay", 15, 40, "r040")
    assert 57 <= raw.failure <= 58 and raw.aging_recordings == raw.failure - 40 and raw["kurtosis"] == pytest.approx(3, abs=0.2)
    assert len(features) == 2 * 60 and features.recording.dtype == np.int64 and features.time_s.isna().all()
    first = features[~features.denoised].iloc[0]
    samples = life()[0]["ay"]
    assert first.rms == pytest.approx(samples.std()) and first["name"] == "r000"
    assert "iframe" in found._repr_html_() and "ay ages from r040" in found["page"].html
    # Nothing ages in noise.
    assert all(row["aging"] is None for row in ballrace.phases(life(60, 0))["phases"])
    with pytest.raises(ballrace.InputError, match="noise: found `loud`, expected finest, each-level"):
        ballrace.phases(life(), noise="loud")
    with pytest.raises(ballrace.InputError, match="healthy: found 2, expected at least 10"):
        ballrace.phases(life(), healthy=2)
    with pytest.raises(ballrace.InputError, match="machine: found 3 recordings"):
        ballrace.phases(life(3, 0))


def test_a_sweep_is_rows_for_a_data_frame_and_goes_on(tmp_path):
    pd = pytest.importorskip("pandas")
    grid = {"solver": "stlsq", "nd": [1, 2], "nmd": 3, "nf": 0, "null": 1, "causal": False}
    told = []
    rows = ballrace.sweep(recordings(), out=tmp_path, progress=lambda done, text: told.append((done, text)), **grid)
    frame = pd.DataFrame(rows)
    assert len(frame) == 6 and set(frame.nd) == {1, 2} and frame.error.isna().all()
    alone = ballrace.fit(recordings(1), solver="stlsq", dimension=3, degree=1, harmonics=0, null=0)
    assert frame.r2[0] == pytest.approx(np.mean(alone.report["scores"]["in_sample"]["derivatives"])) and (frame.seconds > 0).all()
    assert told[-1] == (1.0, "sweep, 6 of 6")
    assert list(frame.columns)[:5] == ["name", "recording", "nd", "nmd", "nf"] and set(frame.recording) == {"r0.csv", "r1.csv", "r2.csv"}
    # The same times too: nothing is fitted again.
    assert ballrace.sweep(recordings(), out=tmp_path, **grid) == rows
    assert len((tmp_path / "rows.jsonl").read_text().splitlines()) == 6
    assert len(ballrace.sweep(recordings(1), **grid)) == 2
    with pytest.raises(ballrace.InputError, match="unknown field `degree`"):
        ballrace.sweep(recordings(), degree=2)
    with pytest.raises(ballrace.InputError, match=r"filter: found `fir`.*db1"):
        ballrace.sweep(recordings(), filter="fir")
    with pytest.raises(ballrace.InputError, match=r"range: found \[0, 9\], expected within 0 to 3"):
        ballrace.sweep(recordings(), range=[0, 9])
    with pytest.raises(ballrace.InputError, match="found two of the name r0.csv"):
        ballrace.sweep([*recordings(1), *recordings(1)], **grid)


def test_lambda_has_a_keyword_that_python_takes():
    grid = {"solver": "stlsq", "nd": 1, "nmd": 3, "nf": 0, "null": 0, "causal": False}
    triples = [[0.5, 0.01, 0.01], [0.5, 0.01, 0.1]]
    rows = ballrace.sweep(recordings(1), lambda_=triples, **grid)
    assert [row["lambda3"] for row in rows] == [0.01, 0.1]
    assert [row["lambda3"] for row in ballrace.sweep(recordings(1), **grid, **{"lambda": triples[1]})] == [0.1]
    with pytest.raises(ballrace.InputError, match="both lambda_ and lambda"):
        ballrace.sweep(recordings(1), lambda_=triples, **{"lambda": triples})
    with pytest.raises(ballrace.InputError, match="lambda: found a negative"):
        ballrace.sweep(recordings(1), lambda_=[0.5, -0.01, 0.01])


def test_a_preset_gives_the_rows_of_the_command(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    for name, made in (("Bearing3_3", life()), ("healthy", life(60, 0))):
        (tmp_path / name).mkdir()
        for n, recording in enumerate(made):
            np.save(tmp_path / name / f"r{n:03}.npy", recording["ay"])
        files = "".join(f'[[recording]]\nfile = "r{n:03}.npy"\n' for n in range(len(made)))
        (tmp_path / name / "recordings.toml").write_text(f"[defaults]\nsample_rate_hz = 25600.0\n{files}")
    with pytest.warns(UserWarning, match="healthy: channel ch1 shows no aging; left out"):
        rows = ballrace.sweep([tmp_path / "Bearing3_3", tmp_path / "healthy"], preset="fig11", count=1, channel="ch1")
    assert len(rows) == 35 and {row["solver"] for row in rows} == {"stlsq"}
    assert {row["recording"] for row in rows} == {"Bearing3_3/r048"}
    with pytest.warns(UserWarning), pytest.raises(ballrace.InputError, match="no folder with an aging phase"):
        ballrace.sweep(tmp_path / "healthy", preset="fig11", channel="ch1")
    with pytest.raises(ballrace.InputError, match="preset: found `table9`, expected table3, table4, table5, fig10, fig11, all"):
        ballrace.sweep(tmp_path, preset="table9")
    with pytest.raises(ballrace.InputError, match="found the keyword nd beside a preset"):
        ballrace.sweep(tmp_path, preset="table3", nd=2)
    with pytest.raises(ballrace.InputError, match="expected the paths of run-to-failure folders"):
        ballrace.sweep(recordings(), preset="table3")
    with pytest.raises(ballrace.InputError, match="count: found no preset"):
        ballrace.sweep(recordings(), count=2)
    program = shutil.which(os.environ.get("BALLRACE", "ballrace"))
    if program is None:
        pytest.skip("no ballrace program to compare with: set $BALLRACE or $PATH")
    line = [program, "sweep", "--preset", "fig11", "Bearing3_3", "--count", "1", "--channel", "ch1", "--out", "out"]
    subprocess.run(line, cwd=tmp_path, check=True, capture_output=True)
    command = parquet.read_table(tmp_path / "out" / "sweep.parquet").to_pylist()
    for row in (*rows, *command):
        del row["seconds"]
    assert rows == command


def test_results_show_themselves_in_a_notebook():
    rig = ballrace.Rig(SDOF)
    drive = [ballrace.Recording({"u": tones(3000, seed=n)}, 500.0, name=f"r{n}") for n in range(4)]
    moved = [ballrace.Recording({"u": m["u"], "q": m["q"]}, 500.0, name=m.name) for m in rig.predict(drive)]
    calibrated, about = ballrace.calibrate(ballrace.Rig(SDOF + 'unknown = ["stiffness_n_per_m"]\n'), moved)
    assert about["estimates"][0]["value"] == pytest.approx(800.0, rel=0.01) and "stiffness" in about["page"].html
    assert "stiffness_n_per_m" in calibrated._repr_html_()
    model = small()
    for shown in (about, model, ballrace.monitor(model, recordings()), ballrace.spectra(recordings(1))):
        assert "<iframe" in shown._repr_html_()


def test_tables_go_in_and_out():
    pytest.importorskip("narwhals")
    from ballrace import tables

    recording = ballrace.Recording({"ax": tones(100), "ay": tones(100, seed=1)}, 1000.0)
    for made in ("pandas", "polars", "arrow"):
        pytest.importorskip({"arrow": "pyarrow"}.get(made, made))
        again = tables.recording(getattr(tables, made)(recording))
        assert again.sample_rate_hz == pytest.approx(1000.0)
        np.testing.assert_array_equal(again["ay"], recording["ay"])
    with pytest.raises(ballrace.InputError, match="column note"):
        import pandas as pd

        tables.recording(pd.DataFrame({"note": ["a", "b"]}), sample_rate_hz=10.0)


def test_the_equations_of_lorenz_are_found():
    def slope(x):
        return np.stack([10 * (x[1] - x[0]), x[0] * (28 - x[2]) - x[1], x[0] * x[1] - 8 / 3 * x[2]])

    x, h, states = np.array([-8.0, 8.0, 27.0]), 1e-3, []
    for _ in range(10_000):
        states.append(x)
        k1 = slope(x)
        k2 = slope(x + 0.5 * h * k1)
        k3 = slope(x + 0.5 * h * k2)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(x + h * k3))
    states = np.array(states)
    a, b, c = states.T
    names = ["1", "x", "y", "z", "xx", "xy", "xz", "yy", "yz", "zz"]
    theta = np.stack([np.ones_like(a), a, b, c, a * a, a * b, a * c, b * b, b * c, c * c], axis=1)
    found = ballrace.stlsq(theta, np.stack([slope(s) for s in states]))
    terms = [{n: v for n, v in zip(names, column) if v != 0} for column in found.T]
    expected = [{"x": -10, "y": 10}, {"x": 28, "y": -1, "xz": -1}, {"z": -8 / 3, "xy": 1}]
    for one, other in zip(terms, expected):
        assert one == pytest.approx(other, rel=1e-6)


def test_estimators_are_scikit_learns():
    pytest.importorskip("sklearn")
    from ballrace.sklearn import STLSQ, SindyNN
    from sklearn.base import clone
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import PolynomialFeatures
    from sklearn.utils.estimator_checks import check_estimator

    check_estimator(STLSQ())
    x = np.random.default_rng(0).standard_normal((500, 2))
    line = make_pipeline(PolynomialFeatures(3), STLSQ(threshold=1e-3)).fit(x, 2 * x[:, 0] - x[:, 0] * x[:, 1])
    assert line.score(x, 2 * x[:, 0] - x[:, 0] * x[:, 1]) == pytest.approx(1.0)
    assert np.count_nonzero(line[-1].coef_) == 2
    made = clone(SindyNN(dimension=3, degree=1, harmonics=0, max_steps=50))
    rows = np.stack([tones(3000, seed=n) for n in range(3)])
    assert made.fit(rows).predict(rows).shape[0] == 3 and made.score(rows) <= 1.0
