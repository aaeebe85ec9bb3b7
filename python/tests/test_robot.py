"""Loads, contacts, twins, plans, inspection, figures and reports."""

import copy
import pickle
import warnings

import numpy as np
import pytest

import torquewise


def test_inspect_says_what_a_log_holds(train):
    found = torquewise.inspect(train)

    assert found.rows == 6000 and found.rate_hz == pytest.approx(100.0)
    assert [joint["name"] for joint in found.joints] == ["joint1", "joint2"]
    assert "6000 rows of 2 joints" in repr(found)
    with pytest.raises(AttributeError, match="has no"):
        found.nothing  # noqa: B018


def test_patterns_label_every_row(train):
    found = torquewise.patterns(train)

    assert len(found.labels) == 6000 and sum(found.counts.values()) == 6000
    assert all(count > 100 for count in found.counts.values())


def test_a_twin_moves_as_its_model_says(chain):
    own = torquewise.simulate(chain, seconds=5, rate=100, motion="sines", seed=4)

    assert np.allclose(own["tau"], chain.torque(own["q"], own["dq"], own["ddq"]))
    assert own["joints"] == chain.joints


def test_control_tracks_better_the_more_a_model_knows(chain):
    found = torquewise.control(chain, "puma560-3", seconds=2, perfect=True)

    errors = {name: own.rms_error.max() for name, own in found.items()}
    assert list(found) == [
        "pid",
        "controller1",
        "controller2",
        "controller1_perfect",
        "controller2_perfect",
    ]
    assert errors["controller2_perfect"] < errors["controller2"] < 0.1 * errors["controller1"]
    assert errors["controller1"] < errors["pid"]
    own = found["pid"]
    late = own.t >= own.t[-1] / 2
    assert np.allclose(own.rms_error, np.sqrt((own.error[late] ** 2).mean(axis=0)))
    assert own.to_frame().shape == (len(own.t), 9)


def test_control_follows_a_motion_of_ones_own_within_the_limits_of_drives(chain):
    wanted = torquewise.simulate("puma560-3", motion="sines", seconds=1, rate=1000, seed=3)

    found = torquewise.control(
        chain, chain, wanted, controllers=["pid"], torque_limit=5.0, settle=0
    )
    tau, saturated = found["pid"].tau, found["pid"].saturated
    assert len(tau) == len(wanted["t"]) and np.abs(tau).max() <= 5.0
    assert np.allclose(saturated, (np.abs(tau) >= 5.0).mean(axis=0)) and saturated.max() > 0

    free = torquewise.control(chain, chain, wanted, controllers=["pid"], settle=0)["pid"]
    assert np.allclose(free.q + free.error, wanted["q"])


@pytest.mark.parametrize(
    "wrong, named",
    [
        (dict(arm="planar-2"), "expected the joints of the model, joint1"),
        (dict(controllers=["fast"]), "controllers"),
        (dict(settle=1), "settle=1 leaves nothing of 1 s"),
        (dict(delay=9), "delay"),
        (dict(rotor=[0.1, 0.1]), "rotor"),
        (dict(motion={"t": [0, 1]}, seconds=None), "q is missing"),
        (dict(motion={"t": [0, 1]}), "seconds would be ignored"),
        (dict(noise=float("nan")), "noise"),
    ],
)
def test_control_refuses_what_cannot_be(chain, wrong, named):
    with pytest.raises(ValueError, match=named):
        torquewise.control(chain, **{"arm": "puma560-3", "seconds": 1, **wrong})


def test_arms_are_listed_and_unknown_ones_refused():
    assert torquewise.arms()["planar-2"] == 2
    with pytest.raises(ValueError, match="no arm is called"):
        torquewise.simulate("robby")


def test_noise_is_as_loud_as_asked_for():
    clean, noisy = (torquewise.simulate("planar-2", seconds=20, case=case) for case in (1, 2))
    noise = noisy["q"] - clean["q"]

    db = 10 * np.log10((clean["q"] ** 2).mean(axis=0) / (noise**2).mean(axis=0))
    assert np.allclose(db, 70.0, atol=3.0)


def test_motions_are_planned_within_limits():
    found = torquewise.excite(
        "planar-2", seconds=(10, 30, 40), tries=1, max_velocity={"joint1": 0.5, "joint2": 1.0}
    )

    assert [own["name"] for own in found] == ["standstill", "uniform", "variable"]
    for own in found:
        assert np.abs(own["dq"][:, 0]).max() <= 0.5
        assert "joint_names" in own["joint_trajectory"]


def test_a_plan_keeps_to_limits_of_the_torque():
    limit = {"joint1": 26.0, "joint2": 5.0}
    found = torquewise.excite("planar-2", seconds=(10, 30, 40), tries=1, torque_limit=limit)

    arm = torquewise.simulate("planar-2", seconds=20, rate=100, seed=1)
    model = torquewise.fit(arm, filter="none").model
    for own in found:
        tau = model.torque(own["q"], own["dq"], own["ddq"])
        assert (np.abs(tau).max(axis=0) <= [26.2, 5.05]).all()
    with pytest.raises(ValueError, match="joint1"):
        torquewise.excite("planar-2", seconds=(10, 30, 40), tries=1, torque_limit=0.1)


def test_a_load_is_weighed(chain):
    """A log of the arm that carries 1 kg, made by adding it to the twin."""
    free = torquewise.simulate(chain, seconds=20, rate=100, seed=7)
    mass, center = 1.0, np.array([0.05, 0.0, 0.02])
    text = __import__("json").loads(chain.to_json())
    link = text["chain"]["links"][-1]
    x, y, z = center
    spread = 1e-3
    load = [
        mass,
        *(mass * center),
        mass * (y * y + z * z) + spread,
        mass * (x * x + z * z) + spread,
        mass * (x * x + y * y) + spread,
        -mass * x * y,
        -mass * x * z,
        -mass * y * z,
    ]
    text["chain"]["links"][-1] = [own + extra for own, extra in zip(link, load)]
    loaded = torquewise.Model.from_json(__import__("json").dumps(text))
    log = {**free, "tau": loaded.torque(free["q"], free["dq"], free["ddq"])}

    found = torquewise.payload(chain, log, filter="none")

    assert found.mass == pytest.approx(1.0, rel=0.02)
    assert found.to_frame().loc["mass [kg]", "value"] == found.mass
    assert found.lighter is None
    bare = torquewise.payload(found.model, free, filter="none")
    assert bare.lighter == pytest.approx(1.0, rel=0.02) and "lighter" in bare.hints[0]
    assert np.allclose(found.center, center, atol=5e-3)
    assert max(found.residual_with) < max(found.residual_without)
    assert np.allclose(
        found.model.torque(free["q"], free["dq"], free["ddq"]), log["tau"], atol=0.05
    )

    both = torquewise.fit(free, loaded=[log, log], friction="linear", progress=False)
    alone = torquewise.payload(both.model, log, filter="none")

    assert [load.mass for load in both.loads] == [alone.mass] * 2
    assert alone.mass == pytest.approx(1.0, rel=0.05)
    assert [load.mass for load in pickle.loads(pickle.dumps(both)).loads] == [alone.mass] * 2

    # The columns weigh the load at half of what it weighs.
    drives = torquewise.gains(chain, log, known_mass=2.0, filter="none")

    assert drives.apparent_mass == pytest.approx(1.0, rel=0.02)
    told = drives.gain_errors < 0.02 * drives.gains
    assert told.sum() >= 2 and np.allclose(drives.gains[told], 2.0, rtol=0.05)
    assert any("URDF" in hint for hint in drives.hints)
    assert drives.to_frame().loc[chain.joints[0], "gain"] == drives.gains[0]
    with pytest.raises(ValueError, match="mass"):
        torquewise.gains(chain, log, known_mass=0.0)


def test_a_push_is_found_and_free_motion_is_quiet(chain):
    free, pushed = (
        torquewise.simulate(chain, motion="sines", seconds=seconds, rate=200, seed=seed)
        for seed, seconds in ((8, 120), (9, 30))
    )
    noise = np.random.default_rng(0)
    for log in (free, pushed):
        log["tau"] = log["tau"] + 0.02 * noise.standard_normal(log["tau"].shape)
    push = (pushed["t"] > 15.0) & (pushed["t"] < 15.5)
    pushed["tau"][push, 1] -= 3.0

    found = torquewise.contacts(chain, pushed, free=free, filter="none")

    (contact,) = [own for own in found.contacts if own["factor"] > 2]
    assert contact["joint"] == chain.joints[1] and contact["begin"] == pytest.approx(15.0, abs=0.05)
    assert found.external.shape == (len(found.t), 3) and (found.thresholds > 0).all()
    assert found.plot().axes and found.blind == []


def test_joints_whose_contacts_go_unseen_without_free_motion_are_named(train):
    rough = dict(train, tau=train["tau"].copy())
    # Every 20 s a second of much torque that nothing explains.
    rough["tau"][np.abs(rough["t"] % 20.0 - 10.0) < 0.5, 1] += 6.0 * rough["tau"][:, 1].std()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = torquewise.fit(rough, filter="none").model

    assert torquewise.contacts(model, rough, filter="none").blind == ["joint2"]


def test_a_report_is_a_page_for_a_notebook(fit, test, tmp_path):
    fit.report(tmp_path / "report.html", test=test)

    page = (tmp_path / "report.html").read_text()
    assert page.startswith("<!") and "joint2" in page
    assert fit._repr_html_().startswith("<iframe srcdoc=")
    assert fit.summary()["joints"] == ["joint1", "joint2"]


def test_results_are_pickled(fit, test, train):
    for own in (fit, pickle.loads(pickle.dumps(fit))):
        again = copy.deepcopy(own)
        assert again.model == fit.model and repr(again) == repr(fit)
        assert again.summary() == fit.summary() and again.because == fit.because
        assert again._repr_html_() and again.evaluate(test).rows == 1000
        with pytest.raises(torquewise.FitError, match="keeps no rows"):
            again.report()

    inspection = torquewise.inspect(train)
    assert pickle.loads(pickle.dumps(inspection)) == copy.copy(inspection) == inspection
    found = pickle.loads(pickle.dumps(fit.evaluate(test)))
    assert found.verdict == fit.verdict == "good" and "test error" in found.because[-1]
    covered = found.interval_coverage_percent
    for errors in (found.rmse, found.nrmse_percent, found.r2, found.raw_nrmse_percent, covered):
        assert errors.shape == (2,) and errors.dtype == np.float64


def test_figures_are_drawn(model, chain, test, train):
    pytest.importorskip("matplotlib")
    from matplotlib.figure import Figure

    log = torquewise.simulate("puma560-3", seconds=5, rate=100, seed=5)
    for own in (
        torquewise.plot.torque(model, test),
        torquewise.plot.torque(chain, log, interval=95),
        torquewise.plot.friction(chain),
        torquewise.plot.activation(train),
        torquewise.plot.arm(chain),
    ):
        assert isinstance(own, Figure) and own.axes
    with pytest.raises(ValueError, match="no geometry"):
        torquewise.plot.arm(model)


def test_figures_are_drawn_into_axes_that_are_there(model, chain, test, train):
    plt = pytest.importorskip("matplotlib.pyplot")
    figure, axes = plt.subplots(4, 2)
    space = figure.add_subplot(4, 2, 8, projection="3d")
    free = torquewise.contacts(model, test, filter="none")

    for own in (
        torquewise.plot.torque(model, test, ax=axes[0]),
        torquewise.plot.friction(model, ax=axes[1]),
        torquewise.plot.contacts(free, ax=axes[2]),
        torquewise.plot.activation(train, ax=axes[3, 0]),
        torquewise.plot.arm(chain, ax=space),
    ):
        assert own is figure
    assert all(own.lines or own.collections for own in [*axes.flat[:7], space])
    with pytest.raises(ValueError, match="ax: 3 axes were given, 2 are drawn into"):
        torquewise.plot.torque(model, test, ax=axes.flat[:3])
    with pytest.raises(ValueError, match="three dimensions"):
        torquewise.plot.arm(chain, ax=axes[0, 0])


def test_both_methods_beside_each_other(test):
    train = torquewise.simulate("planar-2", seconds=60, rate=100, case=3, seed=1)
    found = torquewise.compare(train, test, trig_order=2, library="product")

    assert max(found.stepwise_test.nrmse_percent) < max(found.sindy_test.nrmse_percent)
    assert "sindy" in repr(found)


def test_nothing_else_is_imported():
    import subprocess
    import sys

    program = (
        "import sys, torquewise; "
        "print([own for own in ('sklearn', 'pandas', 'matplotlib', 'pyarrow', 'sympy', 'tqdm')"
        " if own in sys.modules])"
    )
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert found.stdout == "[]\n"


def test_samples_are_other_arms_that_the_log_allows(chain):
    for count, seed in [(0, 1), (-1, 1), (3, -1)]:
        with pytest.raises(ValueError, match="one model or more"):
            chain.samples(count, seed=seed)
    with pytest.raises(ValueError, match="no number below 0"):
        chain.export("twins", to="json", samples=-1)
    drawn = chain.samples(3, seed=1)

    assert drawn == chain.samples(3, seed=1) and len({own.to_json() for own in drawn}) == 3
    states = np.random.default_rng(0).normal(size=(3, 50, 3))
    torque = np.array([own.torque(*states) for own in drawn])
    spread, size = torque.std(axis=0).mean(axis=0), chain.torque(*states).std(axis=0)
    assert (spread < 0.2 * size).all() and (spread > 0).all()


def test_a_law_under_which_the_arm_runs_away_does_not_take_the_others_along(chain):
    laws = ("pid", "computed_torque")

    with pytest.warns(UserWarning, match=r"pid: the arm runs away at \d"):
        found = torquewise.control(
            chain, chain, controllers=laws, seconds=4, delay=0.01, bandwidth=30
        )

    assert list(found) == ["computed_torque"]
