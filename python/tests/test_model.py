"""A model from Python: shapes, identities, files, other packages."""

import copy
import json
import pickle
import time

import numpy as np
import pandas as pd
import pytest

import torquewise

RNG = np.random.default_rng(0)


def states(n, m=50):
    return [RNG.uniform(-1, 1, (m, n)) for _ in range(3)]


def test_rows_are_the_states_one_by_one(model):
    q, dq, ddq = states(2)
    one_by_one = [model.torque(*state) for state in zip(q, dq, ddq)]

    assert np.allclose(model.torque(q, dq, ddq), one_by_one, rtol=0, atol=1e-12)
    assert model.mass_matrix(q).shape == (50, 2, 2)
    assert np.array_equal(model.mass_matrix(q)[7], model.mass_matrix(q[7]))


def test_frames_with_default_columns_are_rows_of_states(model):
    q, dq, ddq = states(2)
    frame = pd.DataFrame

    assert np.array_equal(model.torque(frame(q), frame(dq), frame(ddq)), model.torque(q, dq, ddq))
    assert np.array_equal(model.mass_matrix(frame(q)), model.mass_matrix(q))
    assert np.array_equal(model.gravity(frame(q).astype(np.float32)), model.gravity(q.astype("f4")))
    with pytest.raises(ValueError, match="named columns, which would be taken by their place"):
        model.torque(frame(q, columns=["q2", "q1"]), dq, ddq)


@pytest.mark.parametrize("method", ["torque", "parts", "interval"])
def test_one_state_many_and_none_have_results_of_their_shape(method, chain):
    def shapes(*state):
        found = getattr(chain, method)(*state)
        if isinstance(found, dict):
            found = tuple(found.values())
        return {own.shape for own in (found if isinstance(found, tuple) else [found])}

    q, dq, ddq = states(3)

    assert shapes(q[0], dq[0], ddq[0]) == {(3,)}
    assert shapes(q, dq, ddq) == {(50, 3)}
    assert shapes(q[:0], dq[:0], ddq[:0]) == {(0, 3)}


def test_one_state_stands_for_as_many_as_the_others_are(model):
    q, dq, ddq = states(2)
    still = np.zeros(2)

    assert np.array_equal(model.torque(q, still, ddq), model.torque(q, 0 * dq, ddq))
    assert np.array_equal(model.coriolis(q[0], dq), model.coriolis(np.tile(q[0], (50, 1)), dq))


@pytest.mark.parametrize(
    "make, complaint",
    [
        (lambda q: np.ma.masked_greater(q, 0.5), r"value at \[\d+, \d+\] is masked"),
        (lambda q: q.astype(object), "object, not numbers"),
        (lambda q: q > 0, "bool, not numbers"),
        (lambda q: q[None], "3 dimensions"),
    ],
    ids=["masked", "objects", "booleans", "three dimensions"],
)
def test_arrays_that_are_no_states_are_refused(make, complaint, model):
    with pytest.raises(ValueError, match=complaint):
        model.gravity(make(states(2)[0]))


def test_the_parts_make_the_whole(model):
    q, dq, ddq = states(2)
    parts = model.parts(q, dq, ddq)

    assert sorted(parts) == ["coriolis", "friction", "gravity", "inertia"]
    assert np.allclose(sum(parts.values()), model.torque(q, dq, ddq))
    assert np.allclose(parts["inertia"], np.einsum("mij,mj->mi", model.mass_matrix(q), ddq))
    assert np.allclose(parts["coriolis"], np.einsum("mij,mj->mi", model.coriolis_matrix(q, dq), dq))
    assert np.allclose(parts["gravity"], model.gravity(q))


def test_forward_dynamics_is_the_inverse(model):
    q, dq, ddq = states(2)

    assert np.allclose(model.forward_dynamics(q, dq, model.torque(q, dq, ddq)), ddq)


def test_the_truth_of_the_arm_is_found(model):
    """M and V of the built-in arm, as README gives them."""
    mass = model.mass_matrix([0.3, 0.7])
    truth = 0.94 + 0.4 * np.cos(0.7), 0.11 + 0.2 * np.cos(0.7)

    assert np.allclose(mass, [[truth[0], truth[1]], [truth[1], 0.11]], atol=1e-6)


def test_a_held_out_motion_is_predicted(fit, test):
    found = fit.evaluate(test)

    assert max(found.nrmse_percent) < 0.01 and min(found.r2) > 0.999_999
    assert found.rows == 1000 and "joint1" in repr(found)


def test_predict_gives_the_rows_of_the_log(model, test):
    (own,) = model.predict(test, parts=True)

    assert np.allclose(own["tau_hat"], own["tau"], atol=1e-3)
    assert np.allclose(own["gravity"], model.gravity(own["q"]))
    assert own["outside_range"].shape == (len(own["q"]),) and not own["outside_range"].all()
    assert model.outside_range([99.0, 0.0], [0.0, 0.0], [0.0, 0.0]) is True


def test_a_trajectory_becomes_a_frame_and_a_frame_is_a_log(model, test):
    (own,) = model.predict(test)
    table, recorded = own.to_frame(), test.to_frame()

    assert list(table)[:4] == ["t", "outside_range", "q1", "q2"]
    assert np.array_equal(table[["tau_hat1", "tau_hat2"]].to_numpy(), own["tau_hat"])
    assert list(recorded) == [
        "t",
        *(f"{key}{k}" for key in ("q", "dq", "ddq", "tau") for k in (1, 2)),
    ]
    assert model.evaluate(recorded).rmse.tolist() == model.evaluate(test).rmse.tolist()


def test_intervals_of_a_chain_hold_the_torque(chain):
    log = torquewise.simulate("puma560-3", motion="sines", seconds=10, rate=100, seed=5)
    low, high = chain.interval(log["q"], log["dq"], log["ddq"], percent=95)

    assert (low < high).all()
    assert np.mean((low <= log["tau"]) & (log["tau"] <= high)) > 0.9


def test_a_library_has_no_intervals(model):
    with pytest.raises(torquewise.UsageError, match="covariance"):
        model.interval(*states(2))


def test_a_model_is_pickled_copied_saved_and_equal(tmp_path, model, chain):
    model.save(tmp_path / "model.json")

    for own in (
        torquewise.Model.load(tmp_path / "model.json"),
        torquewise.Model.from_json(model.to_json()),
        pickle.loads(pickle.dumps(model)),
        copy.deepcopy(model),
    ):
        assert own == model and type(own) is torquewise.Model
    assert model != chain


def test_equations_in_the_words_of_pysindy(model, capsys):
    names, coefficients = model.get_feature_names(), model.coefficients()

    assert coefficients.shape == (2, len(names))
    assert model.complexity == 8
    assert coefficients[0, names.index("cos(q1)")] == pytest.approx(19.62, rel=1e-6)
    assert "19.6 cos(q1)" in model.equations()[0]
    model.print()
    assert capsys.readouterr().out.startswith("tau1 = ")
    assert "M11" in str(model) and "M11" in model._repr_html_()


def test_sympy_has_the_same_torque(model):
    sympy = pytest.importorskip("sympy")
    own = model.to_sympy()
    q, dq, ddq = (values[0] for values in states(2))
    values = dict(zip((*own.q, *own.dq, *own.ddq), (*q, *dq, *ddq)))

    assert np.allclose(
        np.array(own.torque.subs(values), dtype=float).ravel(), model.torque(q, dq, ddq)
    )
    assert sympy.simplify(own.mass_matrix[0, 1] - own.mass_matrix[1, 0]) == 0


def test_casadi_has_the_same_torque(chain):
    pytest.importorskip("casadi")
    torque, forward, inertia = (
        chain.to_casadi(what) for what in ("torque", "forward_dynamics", "inertia")
    )
    for q, dq, ddq in zip(*states(3, 10)):
        tau = chain.torque(q, dq, ddq)
        assert np.allclose(np.array(torque(q, dq, ddq)).ravel(), tau)
        assert np.allclose(np.array(forward(q, dq, tau)).ravel(), ddq)
        assert np.allclose(np.array(inertia(q)), chain.mass_matrix(q))


def test_jax_differentiates_the_closed_form(model):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    own = model.functions(jax.numpy)
    q, dq, ddq = (jax.numpy.array(values[0]) for values in states(2))
    torque = jax.jit(lambda ddq: jax.numpy.stack(own.torque(q, dq, ddq)))

    assert np.allclose(torque(ddq), model.torque(np.array(q), np.array(dq), np.array(ddq)))
    assert np.allclose(jax.jacobian(torque)(ddq), model.mass_matrix(np.array(q)))


@pytest.mark.parametrize("ending", ["c", "rs", "py", "tex", "urdf", "xml"])
def test_files_for_other_programs_are_written(ending, tmp_path, chain):
    path = tmp_path / f"arm.{ending}"
    chain.export(path)

    assert path.stat().st_size > 500


def test_a_package_for_ros_is_a_folder(tmp_path, chain):
    chain.export(tmp_path / "arm_model", to="ros2")

    assert (tmp_path / "arm_model" / "package.xml").exists()
    with pytest.raises(FileExistsError):
        chain.export(tmp_path / "arm_model", to="ros2")


def test_an_exported_module_computes_the_torque(tmp_path, model):
    namespace = model.functions()
    q, dq, ddq = (values[0] for values in states(2))

    assert np.allclose(namespace.torque(q, dq, ddq), model.torque(q, dq, ddq))


def test_the_urdf_of_the_arm_names_its_joints(chain):
    assert chain.to_urdf().count("<joint") >= 3
    assert "<mujoco" in chain.to_mjcf()


def test_friction_that_remembers_is_followed():
    """A model whose friction has memory: rows are a path, and a state follows the same path."""
    n, text = (
        1,
        torquewise.fit(
            torquewise.simulate("planar-2", seconds=60, rate=100, seed=3), progress=False
        ).model.to_json(),
    )
    model = torquewise.Model.from_json(text)
    assert not model.has_memory and n == 1
    state = model.state()
    q, dq, ddq = states(2, 5)
    for own in zip(q, dq, ddq):
        state.step(own[0])
        assert np.allclose(state.torque(own[1], own[2]), model.torque(*own))
    for again in (copy.deepcopy(state), pickle.loads(pickle.dumps(state))):
        assert np.array_equal(again.torque(dq[-1], ddq[-1]), state.torque(dq[-1], ddq[-1]))
    with pytest.raises(ValueError, match="not of this model"):
        state.__setstate__(([0.0], [0.0]))
    state.reset()
    with pytest.raises(ValueError, match="step"):
        state.friction(dq[0])


def test_a_call_costs_microseconds(model):
    """Measured beside a call of numpy that does as little, in one run."""
    q, dq, ddq = (values[0] for values in states(2))
    calls = 20_000

    def cost(call):
        best = np.inf
        for _ in range(5):
            begin = time.perf_counter()
            for _ in range(calls):
                call()
            best = min(best, time.perf_counter() - begin)
        return best / calls

    own, least = cost(lambda: model.torque(q, dq, ddq)), cost(lambda: np.add(q, dq))
    assert own < 20 * least


def test_pinocchio_moves_the_arm_as_the_model_does(chain):
    pin = pytest.importorskip("pinocchio")
    with pytest.warns(UserWarning, match="not in the Pinocchio model: .*offset torque"):
        own = chain.to_pinocchio()
    data, rng = own.createData(), np.random.default_rng(3)

    assert list(own.names)[1:] == chain.joints and own.armature[0] > 0.1
    for q, dq, ddq in rng.normal(size=(5, 3, 3)):
        moving = pin.rnea(own, data, q, dq, ddq) - pin.rnea(own, data, q, 0 * dq, 0 * ddq)
        parts = chain.parts(q, dq, ddq)
        assert np.allclose(moving, parts["inertia"] + parts["coriolis"], atol=1e-9)


def test_a_rollout_says_how_far_simulated_windows_drift(chain):
    log = torquewise.simulate("puma560-3", seconds=10, rate=100, seed=9, motion="sines")
    assert chain.score(log) == pytest.approx(chain.evaluate(log).r2.mean()) and chain.score(log) < 1

    found = chain.rollout(log, horizons=(0.5, 0.2))

    assert found.horizons.tolist() == [0.2, 0.5] and (found.windows > 5).all()
    assert found.drift.shape == found.hold.shape == (2, 3)
    assert (found.drift < 0.1 * found.hold).all()
    assert found.covered is None
    covered = chain.rollout(log, horizons=(0.5,), samples=10, seed=1).covered
    assert covered.shape == (1, 3) and ((covered >= 0) & (covered <= 1)).all()
    with pytest.raises(ValueError, match="samples"):
        chain.rollout(log, samples=1)
    assert len(found.to_frame()) == 6
    with pytest.raises(ValueError, match="horizons: expected seconds above 0"):
        chain.rollout(log, horizons=(0.0,))


def test_a_rollout_takes_one_time_and_counts_what_ran_away(chain):
    log = torquewise.simulate("puma560-3", seconds=10, rate=100, seed=2)

    found = chain.rollout(log, horizons=0.5)

    assert found.drift.shape == (1, 3) and list(found.ran_away) == [0]
    assert "held, 0.5 s" in repr(found) and "ran away" not in repr(found)


def test_parameters_of_a_chain_have_errors(chain, model):
    found = {(own["joint"], own["name"]): own for own in chain.parameters()}

    # A rigid arm without rotors: what torque tells of the last link is told from zero, springs are none.
    last = found["joint3", "Izz"]
    assert last["resolved"] and last["value"] > 2 * last["std_error"] > 0
    assert {name for joint, name in found if joint == "joint1"} >= {"m·x", "Izz"}
    assert model.parameters() == []


def test_all_terms_are_shown_where_they_are_asked_for(chain):
    some, whole = chain.text(), chain.text(all=True)

    assert "ask for `all`" in some and "ask for `all`" not in whole
    assert len(whole.splitlines()) > len(some.splitlines())
    assert "tau2" in chain.text(1) and "tau1" not in chain.text(1)


def test_a_model_without_use_says_so_wherever_it_goes(tmp_path):
    rng = np.random.default_rng(0)
    t = np.arange(3000) / 100
    q = np.stack([np.sin(t), np.cos(1.3 * t)], axis=1)
    log = {"t": t, "q": q, "tau": rng.normal(size=q.shape)}

    with pytest.warns(UserWarning, match="the model is unusable: held-out"):
        fit = torquewise.fit(log, library="chain", progress=False)

    assert fit.verdict == "unusable"
    fit.save(tmp_path / "arm.json")
    again = torquewise.Model.load(tmp_path / "arm.json")
    assert again.verdict == "unusable" and repr(again).endswith("coefficients; unusable)")
    with pytest.warns(UserWarning, match="do not let it move an arm"):
        again.export(tmp_path / "arm.c")
    assert "unusable by the verdict of its fit" in (tmp_path / "arm.c").read_text()


@pytest.mark.parametrize("part, all_run_away", [(-1.0, True), (0.05, False)])
def test_windows_that_run_away_are_counted_and_do_not_hide_the_others(part, all_run_away, chain):
    own = json.loads(chain.to_json())
    own["chain"]["links"] = [[part * x for x in link] for link in own["chain"]["links"]]
    for drive in own["chain"]["drives"]:
        drive["rotor"]["inertia"] *= abs(part)
    light = torquewise.Model.from_json(json.dumps(own))
    log = torquewise.simulate("puma560-3", seconds=10, rate=100, seed=2)

    found = light.rollout(log, horizons=0.5)

    assert (found.ran_away[0] == found.windows[0] > 5) == all_run_away
    assert found.ran_away[0] > 0 and np.isinf(found.drift).all() == all_run_away
    assert np.isfinite(found.hold).all() and f"{found.ran_away[0]} of" in repr(found)
    assert found.to_frame()["ran_away"].tolist() == [found.ran_away[0]] * 3
