state, observer = arm.State(), arm.Observer()
try:
    state.friction_after([0.0] * arm.JOINTS)
    raise SystemExit("friction of a path that has not begun")
except ValueError:
    pass
for way in EACH:
    if number % RESET == 0:
        state.reset()
        observer.reset()
    state.step(q)
    tau = state.torque_after(dq, ddq)
    y += tau + state.friction_after(dq)
    y += observer.step(GAIN, STEP, q, dq, ddq)
    add(lambda: state.forward_dynamics_after(dq, tau), arm.JOINTS)
