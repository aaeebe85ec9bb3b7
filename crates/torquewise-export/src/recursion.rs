//! The torque of a rigid chain as nodes, by the recursion of Newton and Euler.
//!
//! Numbers of the chain are folded in: what is multiplied by zero or one costs nothing. The
//! acceleration of a point p of a link is a + Up, with U = \[ω̇\]× + \[ω\]×\[ω\]×, and nine entries
//! of U serve force and moment as well (Khalil and Kleinfinger, 1987).

use crate::base_chain::{BaseChain, BaseLink};
use crate::{Graph, Id, Input};

type Vector = [Id; 3];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Motion {
    /// Gravity alone.
    Rest,
    /// Velocities, no gravity.
    Steady,
    Whole,
}

pub(crate) struct Recursion<'a> {
    graph: &'a Graph,
    chain: &'a BaseChain,
    /// Sine and cosine of each joint with its offset, n.
    angles: Vec<[Id; 2]>,
}

struct Moved {
    omega: Vector,
    alpha: Vector,
    acceleration: Vector,
    /// U, row by row.
    spread: [Vector; 3],
}

#[derive(Clone, Copy)]
struct Wrench {
    force: Vector,
    moment: Vector,
}

/// Mass, which slides alone have, first moment and moments of several links together.
struct Composite {
    mass: f64,
    first: Vector,
    moments: [Vector; 3],
}

impl<'a> Recursion<'a> {
    pub(crate) fn new(graph: &'a Graph, chain: &'a BaseChain) -> Self {
        let mut angles = Vec::with_capacity(chain.links.len());
        for link in &chain.links {
            let multiples: Vec<i32> = link.turns.iter().map(|&k| k.into()).collect();
            angles.push(if link.kind.turns() {
                turned(graph, link.offset, [graph.sin(&multiples), graph.cos(&multiples)])
            } else {
                link.offset.map(|x| graph.constant(x))
            });
        }
        Self { graph, chain, angles }
    }

    pub(crate) fn torque(&self, motion: Motion) -> Vec<Id> {
        let moved = self.moved(motion);
        let none = [self.graph.constant(0.0); 3];
        let mut wrench = Wrench { force: none, moment: none };
        let mut torque = Vec::with_capacity(moved.len());
        for (joint, (link, moved)) in self.chain.links.iter().zip(&moved).enumerate().rev() {
            let Wrench { force, moment } = self.wrench(link, moved);
            let force = self.plus(&force, &wrench.force);
            wrench = Wrench { force, moment: self.plus(&moment, &wrench.moment) };
            torque.push(self.effort(link, &wrench));
            wrench = self.carried(joint, &wrench);
        }
        torque.reverse();
        self.load(&mut torque);
        torque
    }

    /// M(q) row by row, n·n: each link with all beyond it as one body.
    pub(crate) fn matrix(&self) -> Vec<Id> {
        let n = self.chain.links.len();
        let zero = self.graph.constant(0.0);
        let mut matrix = vec![zero; n * n];
        let mut beyond = Composite { mass: 0.0, first: [zero; 3], moments: [[zero; 3]; 3] };
        for (j, link) in self.chain.links.iter().enumerate().rev() {
            let all = self.with(link, &beyond);
            let ([x, y, _], [turn, slide]) = (all.first, link.kind.twist);
            let force = self.scaled(turn, &[self.graph.neg(y), x, zero]);
            let push = [zero, zero, self.graph.constant(slide * all.mass)];
            let moment = self.scaled(slide, &[y, self.graph.neg(x), zero]);
            let mut wrench = Wrench {
                force: self.plus(&force, &push),
                moment: self.plus(&self.scaled(turn, &all.moments[2]), &moment),
            };
            for i in (0..=j).rev() {
                let effort = self.effort(&self.chain.links[i], &wrench);
                (matrix[i * n + j], matrix[j * n + i]) = (effort, effort);
                wrench = self.carried(i, &wrench);
            }
            beyond = self.shifted(j, &all);
        }
        // ΓᵀMΓ: rows, then columns.
        matrix.chunks_exact_mut(n).for_each(|row| self.load(row));
        for j in 0..n {
            let mut column: Vec<Id> = (0..n).map(|i| matrix[i * n + j]).collect();
            self.load(&mut column);
            column.into_iter().enumerate().for_each(|(i, entry)| matrix[i * n + j] = entry);
        }
        matrix
    }

    /// Torques of the joints of the chain → those of the coordinates that turn them: Γᵀτ (E18).
    fn load(&self, torque: &mut [Id]) {
        for (joint, link) in self.chain.links.iter().enumerate() {
            for driver in (0..joint).filter(|&driver| link.turns[driver] != 0) {
                let ratio = self.graph.constant(link.turns[driver].into());
                torque[driver] =
                    self.graph.add(torque[driver], self.graph.mul(ratio, torque[joint]));
            }
        }
    }

    fn moved(&self, motion: Motion) -> Vec<Moved> {
        let zero = self.graph.constant(0.0);
        let weighs = matches!(motion, Motion::Rest | Motion::Whole);
        let gravity = self.chain.gravity.map(|g| if weighs { -g } else { 0.0 });
        let (mut omega, mut alpha) = ([zero; 3], [zero; 3]);
        let mut acceleration = gravity.map(|g| self.graph.constant(g));
        let mut all: Vec<Moved> = Vec::new();
        for (joint, link) in self.chain.links.iter().enumerate() {
            if let Some(before) = all.last() {
                let origin = self.origin(joint);
                acceleration =
                    self.plus(&before.acceleration, &self.times(&before.spread, &origin));
                (omega, alpha) = (before.omega, before.alpha);
            }
            let speed = self.driven(joint, Input::Dq);
            let rate = self.driven(joint, Input::Ddq);
            let (speed, rate) = match motion {
                Motion::Rest => (zero, zero),
                Motion::Steady => (speed, zero),
                Motion::Whole => (speed, rate),
            };
            omega = self.inward(joint, &omega);
            alpha = self.inward(joint, &alpha);
            acceleration = self.inward(joint, &acceleration);
            let [turn, slide] = link.kind.twist;
            // ω×z q̇ + z q̈ of what turns, 2 ω×z q̇ + z q̈ of what slides.
            alpha = self.plus(&alpha, &self.along_z(&omega, turn, [speed, rate]));
            let twice = self.graph.add(speed, speed);
            let slid = self.along_z(&omega, slide, [twice, rate]);
            acceleration = self.plus(&acceleration, &slid);
            omega[2] = self.graph.add(omega[2], self.graph.mul(self.graph.constant(turn), speed));
            let spread = self.spread(&omega, &alpha);
            all.push(Moved { omega, alpha, acceleration, spread });
        }
        all
    }

    /// ω×z times a speed, and z times a rate, times a factor.
    fn along_z(&self, omega: &Vector, factor: f64, [speed, rate]: [Id; 2]) -> Vector {
        let graph = self.graph;
        let right = graph.mul(omega[0], speed);
        self.scaled(factor, &[graph.mul(omega[1], speed), graph.neg(right), rate])
    }

    /// What the motor of a link holds of a wrench: its moment about z, its force along it.
    fn effort(&self, link: &BaseLink, wrench: &Wrench) -> Id {
        let [turn, slide] = link.kind.twist.map(|part| self.graph.constant(part));
        let held = self.graph.mul(turn, wrench.moment[2]);
        self.graph.add(held, self.graph.mul(slide, wrench.force[2]))
    }

    /// What turns a joint of the chain: multiples of a signal of the coordinates.
    fn driven(&self, joint: usize, signal: fn(usize) -> Input) -> Id {
        let mut sum = self.graph.input(signal(joint));
        let turns = &self.chain.links[joint].turns;
        for driver in (0..joint).filter(|&driver| turns[driver] != 0) {
            let ratio = self.graph.constant(turns[driver].into());
            sum = self.graph.add(sum, self.graph.mul(ratio, self.graph.input(signal(driver))));
        }
        sum
    }

    fn spread(&self, omega: &Vector, alpha: &Vector) -> [Vector; 3] {
        let graph = self.graph;
        let [x, y, z] = *omega;
        let [xx, yy, zz] = [graph.mul(x, x), graph.mul(y, y), graph.mul(z, z)];
        let [xy, xz, yz] = [graph.mul(x, y), graph.mul(x, z), graph.mul(y, z)];
        let diagonal = [[yy, zz], [xx, zz], [xx, yy]].map(|[a, b]| graph.neg(graph.add(a, b)));
        [
            [diagonal[0], graph.sub(xy, alpha[2]), graph.add(xz, alpha[1])],
            [graph.add(xy, alpha[2]), diagonal[1], graph.sub(yz, alpha[0])],
            [graph.sub(xz, alpha[1]), graph.add(yz, alpha[0]), diagonal[2]],
        ]
    }

    /// Force and moment that the motion of a link takes: ma + Us, and Jω̇ + ω×Jω + s×a.
    fn wrench(&self, link: &BaseLink, moved: &Moved) -> Wrench {
        let [mass, x, y, z, ..] = link.inertial;
        let first = [x, y, z].map(|s| self.graph.constant(s));
        let force = self.times(&moved.spread, &first);
        let force = self.plus(&force, &self.scaled(mass, &moved.acceleration));
        let turning = self.turning(link, moved);
        let weight = self.cross(&first, &moved.acceleration);
        Wrench { force, moment: self.plus(&turning, &weight) }
    }

    /// Jω̇ + ω×Jω.
    fn turning(&self, link: &BaseLink, moved: &Moved) -> Vector {
        let [.., xx, _, zz, xy, xz, yz] = link.inertial;
        let [[_, u_xy, u_xz], [u_yx, _, u_yz], [u_zx, u_zy, _]] = moved.spread;
        let ([x, y, z], alpha, graph) = (moved.omega, moved.alpha, self.graph);
        let squares =
            [(y, z), (z, x), (x, y)].map(|(a, b)| graph.sub(graph.mul(a, a), graph.mul(b, b)));
        let products = [(y, z), (x, z), (x, y)].map(|(a, b)| graph.mul(a, b));
        let rows = [
            [(xx, alpha[0]), (zz, products[0]), (-xy, u_zx), (xz, u_yx), (yz, squares[0])],
            [(0.0, alpha[1]), (xx - zz, products[1]), (xy, u_zy), (-yz, u_xy), (xz, squares[1])],
            [(zz, alpha[2]), (-xx, products[2]), (-xz, u_yz), (yz, u_xz), (xy, squares[2])],
        ];
        let part = |(weight, node)| graph.mul(graph.constant(weight), node);
        rows.map(|parts| graph.sum(&parts.map(part)))
    }

    fn with(&self, link: &BaseLink, beyond: &Composite) -> Composite {
        let [mass, x, y, z, xx, _, zz, xy, xz, yz] = link.inertial;
        let own = [[xx, xy, xz], [xy, 0.0, yz], [xz, yz, zz]];
        let own = own.map(|row| row.map(|x| self.graph.constant(x)));
        let first = [x, y, z].map(|x| self.graph.constant(x));
        let moments = [0, 1, 2].map(|i| self.plus(&own[i], &beyond.moments[i]));
        Composite { mass: mass + beyond.mass, first: self.plus(&first, &beyond.first), moments }
    }

    /// The same body in the frame before that of a joint, about its origin.
    fn shifted(&self, joint: usize, body: &Composite) -> Composite {
        let graph = self.graph;
        let by = self.origin(joint);
        let turned_first = self.outward(joint, &body.first);
        // With half of the mass at the origin, 2 o·s + m o·o is 2 o·s again, and o sᵀ + s oᵀ likewise.
        let first = self.plus(&turned_first, &self.scaled(0.5 * body.mass, &by));
        let columns = body.moments.map(|column| self.outward(joint, &column));
        let rows = [0, 1, 2].map(|i| columns.map(|column| column[i]));
        let mut moments = rows.map(|row| self.outward(joint, &row));
        let along = [0, 1, 2].map(|i| graph.mul(by[i], first[i]));
        for i in 0..3 {
            // The tensor is symmetric: entries below the diagonal are those above.
            for j in i..3 {
                let shift = if i == j {
                    let sum = graph.add(along[(i + 1) % 3], along[(i + 2) % 3]);
                    graph.add(sum, sum)
                } else {
                    let [left, right] = [graph.mul(by[i], first[j]), graph.mul(by[j], first[i])];
                    graph.neg(graph.add(left, right))
                };
                moments[i][j] = graph.add(moments[i][j], shift);
                moments[j][i] = moments[i][j];
            }
        }
        let first = self.plus(&first, &self.scaled(0.5 * body.mass, &by));
        Composite { mass: body.mass, first, moments }
    }

    /// A wrench in the frame before that of a joint, about its origin.
    fn carried(&self, joint: usize, wrench: &Wrench) -> Wrench {
        let force = self.outward(joint, &wrench.force);
        let moment = self.outward(joint, &wrench.moment);
        let origin = self.origin(joint);
        Wrench { force, moment: self.plus(&moment, &self.cross(&origin, &force)) }
    }

    /// The origin of the frame of a joint, in the frame before: what slides moves it along its z.
    fn origin(&self, joint: usize) -> Vector {
        let (graph, link) = (self.graph, &self.chain.links[joint]);
        let own = link.origin.map(|x| graph.constant(x));
        let ([sine, cosine], [_, slide]) = (link.twist, link.kind.twist);
        let q = graph.input(Input::Q(joint));
        let along = [0.0, -slide * sine, slide * cosine].map(|x| graph.mul(graph.constant(x), q));
        self.plus(&own, &along)
    }

    fn scaled(&self, factor: f64, v: &Vector) -> Vector {
        v.map(|x| self.graph.mul(self.graph.constant(factor), x))
    }

    /// Components in the frame of a joint of a vector of the frame before.
    fn inward(&self, joint: usize, v: &Vector) -> Vector {
        let [sine, cosine] = self.chain.links[joint].twist.map(|x| self.graph.constant(x));
        let [z, y] = self.turn([sine, cosine], [v[2], v[1]], -1.0);
        let [y, x] = self.turn(self.angles[joint], [y, v[0]], -1.0);
        [x, y, z]
    }

    /// Components in the frame before that of a joint.
    fn outward(&self, joint: usize, v: &Vector) -> Vector {
        let [sine, cosine] = self.chain.links[joint].twist.map(|x| self.graph.constant(x));
        let [y, x] = self.turn(self.angles[joint], [v[1], v[0]], 1.0);
        let [z, y] = self.turn([sine, cosine], [v[2], y], 1.0);
        [x, y, z]
    }

    /// (second, first) component turned forward or, with a direction of −1, back.
    fn turn(&self, [sine, cosine]: [Id; 2], [y, x]: [Id; 2], direction: f64) -> [Id; 2] {
        let graph = self.graph;
        let [xc, yc] = [graph.mul(x, cosine), graph.mul(y, cosine)];
        let [xs, ys] = [graph.mul(x, sine), graph.mul(y, sine)];
        if direction > 0.0 {
            [graph.add(yc, xs), graph.sub(xc, ys)]
        } else {
            [graph.sub(yc, xs), graph.add(xc, ys)]
        }
    }

    fn plus(&self, a: &Vector, b: &Vector) -> Vector {
        [0, 1, 2].map(|i| self.graph.add(a[i], b[i]))
    }

    fn times(&self, matrix: &[Vector; 3], v: &Vector) -> Vector {
        matrix.map(|row| self.graph.sum(&[0, 1, 2].map(|i| self.graph.mul(row[i], v[i]))))
    }

    fn cross(&self, a: &Vector, b: &Vector) -> Vector {
        let graph = self.graph;
        [(1, 2), (2, 0), (0, 1)]
            .map(|(i, j)| graph.sub(graph.mul(a[i], b[j]), graph.mul(a[j], b[i])))
    }
}

/// Sine and cosine of a + b, of those of a number a and an angle b.
fn turned(graph: &Graph, offset: [f64; 2], [sine, cosine]: [Id; 2]) -> [Id; 2] {
    let [s, c] = offset.map(|x| graph.constant(x));
    let (sc, cs) = (graph.mul(s, cosine), graph.mul(c, sine));
    let (cc, ss) = (graph.mul(c, cosine), graph.mul(s, sine));
    [graph.add(sc, cs), graph.sub(cc, ss)]
}
