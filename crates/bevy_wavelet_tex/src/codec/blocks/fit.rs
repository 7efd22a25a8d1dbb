//! End points of a block on a line through `C` channels, by the error that counts.
//!
//! Each channel has a table of what a pair of end points decodes to at the four places of the line,
//! in the units of the error. A start along a principal axis is improved by moving end points a step
//! at a time, each texel taking its best place anew, until no move helps.

/// What end points decode to: one channel.
pub struct Channel {
    /// Number of values of an end point.
    levels: usize,
    /// Decoded values at the places 0, 1/3, 2/3, 1 of the line, for each pair of end points.
    table: Vec<[f32; 4]>,
}

impl Channel {
    /// `decode` takes a stored value in `[0, 1]`.
    pub fn new(levels: usize, decode: impl Fn(f32) -> f32) -> Self {
        let unit = |level: usize| level as f32 / (levels - 1) as f32;
        let pairs = (0..levels).flat_map(|a| (0..levels).map(move |b| (a, b)));
        let table = pairs.map(|(a, b)| {
            [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|t| decode(unit(a) + (unit(b) - unit(a)) * t))
        });
        Self {
            levels,
            table: table.collect(),
        }
    }

    fn palette(&self, [a, b]: [u8; 2]) -> &[f32; 4] {
        &self.table[a as usize * self.levels + b as usize]
    }
}

/// A block to fit.
pub struct Target<const C: usize> {
    /// What the decoder should give, in the units of the error.
    pub wanted: [[f32; 16]; C],
    /// The same as it would be stored, in `[0, 1]`: the principal axis is sought there.
    pub stored: [[f32; 16]; C],
}

/// The best that was found.
#[derive(Clone, Copy)]
pub struct Fit<const C: usize> {
    /// Both end points of each channel, as levels.
    pub ends: [[u8; 2]; C],
    /// Squared error of the block.
    pub error: f32,
}

/// How many starts a fit has: more are slower and a little better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Starts {
    /// The whole length of the principal axis.
    One,
    /// Also a shorter part of it.
    Two,
    /// The same of the second axis.
    Four,
}

/// Moves of a channel's two end points.
const MOVES: [[i16; 2]; 12] = [
    [1, 0],
    [-1, 0],
    [0, 1],
    [0, -1],
    [1, 1],
    [-1, -1],
    [1, -1],
    [-1, 1],
    [2, 0],
    [-2, 0],
    [0, 2],
    [0, -2],
];

/// Rounds of moves, should they not end before.
const MAX_ROUNDS: usize = 16;

/// Fits a block.
pub fn fit<const C: usize>(channels: &[Channel; C], target: &Target<C>, starts: Starts) -> Fit<C> {
    let lengths: &[f32] = if starts == Starts::One {
        &[1.0]
    } else {
        &[1.0, 0.7]
    };
    let axes = principal_axes(target);
    let axes = &axes[..if starts == Starts::Four { 2 } else { 1 }];
    let mut best: Option<Fit<C>> = None;
    for axis in axes {
        for length in lengths {
            let found = refine(channels, target, start(channels, target, axis, *length));
            if best.is_none_or(|best| found.error < best.error) {
                best = Some(found);
            }
        }
    }
    best.expect("there is a start")
}

/// The place on the line, 0 to 3, that is best for each texel.
pub fn places<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    ends: &[[u8; 2]; C],
) -> [u8; 16] {
    let sums = sum::<C>(&std::array::from_fn(|c| {
        distances(&channels[c], &target.wanted[c], ends[c])
    }));
    std::array::from_fn(|i| {
        let mut best = 0;
        for place in 1..4 {
            if sums[place][i] < sums[best][i] {
                best = place;
            }
        }
        best as u8
    })
}

/// Squared distance of each texel from each place, in one channel.
type Distances = [[f32; 16]; 4];

fn distances(channel: &Channel, wanted: &[f32; 16], ends: [u8; 2]) -> Distances {
    channel
        .palette(ends)
        .map(|value| wanted.map(|wanted| (value - wanted) * (value - wanted)))
}

fn sum<const C: usize>(distances: &[Distances; C]) -> Distances {
    let mut sums = distances[0];
    for channel in &distances[1..] {
        for (sums, channel) in sums.iter_mut().zip(channel) {
            for (sum, distance) in sums.iter_mut().zip(channel) {
                *sum += distance;
            }
        }
    }
    sums
}

/// Error of a channel with these end points, added to that of the `others`, with the best place for
/// each texel.
fn error(others: &Distances, channel: &Channel, wanted: &[f32; 16], ends: [u8; 2]) -> f32 {
    let mut least = [f32::INFINITY; 16];
    for (value, others) in channel.palette(ends).iter().zip(others) {
        for i in 0..16 {
            let difference = value - wanted[i];
            least[i] = least[i].min(others[i] + difference * difference);
        }
    }
    least.iter().sum()
}

fn refine<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    mut ends: [[u8; 2]; C],
) -> Fit<C> {
    let mut all: [Distances; C] =
        std::array::from_fn(|c| distances(&channels[c], &target.wanted[c], ends[c]));
    let mut best = f32::INFINITY;
    for _ in 0..MAX_ROUNDS {
        let mut moved = false;
        for c in 0..C {
            let (channel, wanted) = (&channels[c], &target.wanted[c]);
            let own = std::mem::replace(&mut all[c], [[0.0; 16]; 4]);
            let others = sum(&all);
            all[c] = own;
            if best.is_infinite() {
                best = error(&others, channel, wanted, ends[c]);
            }
            for step in MOVES {
                let tried = [0, 1].map(|e| i16::from(ends[c][e]) + step[e]);
                if tried.iter().any(|&e| e < 0 || e >= channel.levels as i16) {
                    continue;
                }
                let tried = tried.map(|e| e as u8);
                let error = error(&others, channel, wanted, tried);
                // What is lost in the last bits is no improvement, and could go in circles.
                if error < best * (1.0 - 1e-6) {
                    best = error;
                    ends[c] = tried;
                    moved = true;
                }
            }
            all[c] = distances(channel, wanted, ends[c]);
        }
        if !moved {
            break;
        }
    }
    Fit { ends, error: best }
}

/// End points at the extremes of the texels along an axis through their mean.
fn start<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    axis: &[f32; C],
    length: f32,
) -> [[u8; 2]; C] {
    let means = means(target);
    let mut range = [f32::INFINITY, f32::NEG_INFINITY];
    for i in 0..16 {
        let place: f32 = (0..C)
            .map(|c| (target.stored[c][i] - means[c]) * axis[c])
            .sum();
        range = [range[0].min(place), range[1].max(place)];
    }
    std::array::from_fn(|c| {
        let last = (channels[c].levels - 1) as f32;
        range.map(|place| {
            let value = means[c] + length * place * axis[c];
            (value * last).round().clamp(0.0, last) as u8
        })
    })
}

fn means<const C: usize>(target: &Target<C>) -> [f32; C] {
    std::array::from_fn(|c| target.stored[c].iter().sum::<f32>() / 16.0)
}

/// The first two principal axes of the stored texels, by power iteration.
fn principal_axes<const C: usize>(target: &Target<C>) -> [[f32; C]; 2] {
    let means = means(target);
    let mut covariance = [[0.0f32; C]; C];
    for i in 0..16 {
        for a in 0..C {
            for b in 0..C {
                covariance[a][b] +=
                    (target.stored[a][i] - means[a]) * (target.stored[b][i] - means[b]);
            }
        }
    }
    let mut axes = [[0.0; C]; 2];
    for (number, axis) in axes.iter_mut().enumerate() {
        // Not orthogonal to anything likely.
        *axis = std::array::from_fn(|c| {
            if c % 2 == number {
                1.0
            } else {
                0.7 - 0.4 * number as f32
            }
        });
        for _ in 0..8 {
            let next: [f32; C] =
                std::array::from_fn(|a| (0..C).map(|b| covariance[a][b] * axis[b]).sum());
            let length = next.iter().map(|v| v * v).sum::<f32>().sqrt();
            if length < 1e-12 {
                break;
            }
            *axis = next.map(|v| v / length);
        }
        let spread: f32 = (0..C)
            .flat_map(|a| (0..C).map(move |b| (a, b)))
            .map(|(a, b)| axis[a] * covariance[a][b] * axis[b])
            .sum();
        for a in 0..C {
            for b in 0..C {
                covariance[a][b] -= spread * axis[a] * axis[b];
            }
        }
    }
    axes
}
