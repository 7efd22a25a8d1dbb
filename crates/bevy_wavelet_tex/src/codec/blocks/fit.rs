//! Search for the endpoints of a block on a line through `C` channels, by the error of the decoded
//! values.
//!
//! Each channel has a table of the values to which a pair of endpoints decodes at the four
//! positions on the line, in the units of the error. The search starts along a principal axis and
//! moves endpoints by a step at a time, with the best position for each texel after each step,
//! until no step reduces the error.

/// The decoded values of all endpoints of one channel.
pub struct Channel {
    /// Number of values that an endpoint can have.
    levels: usize,
    /// Decoded values at the positions 0, 1/3, 2/3 and 1 on the line, for each pair of endpoints.
    table: Vec<[f32; 4]>,
}

impl Channel {
    /// Makes the table. `decode` converts a stored value in `[0, 1]`.
    pub fn new(levels: usize, decode: impl Fn(f32) -> f32) -> Self {
        Self::of(levels, |a, b| {
            [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|t| decode(a + (b - a) * t))
        })
    }

    /// Makes the table of the mode of BC1 that has three colours on the line, and black in place of the fourth.
    pub fn with_black(levels: usize) -> Self {
        Self::of(levels, |a, b| [a, (a + b) / 2.0, b, 0.0])
    }

    fn of(levels: usize, values: impl Fn(f32, f32) -> [f32; 4]) -> Self {
        let unit = |level: usize| level as f32 / (levels - 1) as f32;
        let pairs = (0..levels).flat_map(|a| (0..levels).map(move |b| (a, b)));
        let table = pairs.map(|(a, b)| values(unit(a), unit(b)));
        Self {
            levels,
            table: table.collect(),
        }
    }

    fn palette(&self, [a, b]: [u8; 2]) -> &[f32; 4] {
        &self.table[a as usize * self.levels + b as usize]
    }
}

/// The values of a block that a fit approximates.
pub struct Target<const C: usize> {
    /// The values that the decoder should return, in the units of the error.
    pub wanted: [[f32; 16]; C],
    /// The same values as they would be stored, in `[0, 1]`. The principal axis is that of these.
    pub stored: [[f32; 16]; C],
}

/// The best endpoints that a fit found.
#[derive(Clone, Copy)]
pub struct Fit<const C: usize> {
    /// Both endpoints of each channel, as integer levels.
    pub ends: [[u8; 2]; C],
    /// Squared error of the block.
    pub error: f32,
}

/// Number of starting points of a fit. More of them take more time and reduce the error a little.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Starts {
    /// One start: the whole length of the principal axis.
    One,
    /// Two starts: the whole axis and a shorter part of it.
    Two,
    /// Four starts: the same two on each of the first two principal axes.
    Four,
    /// The second of two starts alone, for a block that was fitted from the first one.
    Second,
}

/// Steps of a channel's two endpoints.
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

/// Largest number of rounds of steps.
const MAX_ROUNDS: usize = 16;

/// Fits the endpoints of a block.
pub fn fit<const C: usize>(channels: &[Channel; C], target: &Target<C>, starts: Starts) -> Fit<C> {
    let lengths: &[f32] = match starts {
        Starts::One => &[1.0],
        Starts::Second => &[0.7],
        Starts::Two | Starts::Four => &[1.0, 0.7],
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

/// The position on the line, 0 to 3, with the least error for each texel.
pub fn positions<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    ends: &[[u8; 2]; C],
) -> [u8; 16] {
    let sums = sum::<C>(&std::array::from_fn(|c| {
        distances(&channels[c], &target.wanted[c], ends[c])
    }));
    std::array::from_fn(|i| {
        let mut best = 0;
        for position in 1..4 {
            if sums[position][i] < sums[best][i] {
                best = position;
            }
        }
        best as u8
    })
}

/// Squared distance of each texel from each position on the line, in one channel.
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

/// Error of a channel with these endpoints, added to that of the `others`, with the best position
/// for each texel.
fn error(others: &Distances, channel: &Channel, wanted: &[f32; 16], ends: [u8; 2]) -> f32 {
    let mut least = [f32::INFINITY; 16];
    for (value, others) in channel.palette(ends).iter().zip(others) {
        for i in 0..16 {
            let difference = value - wanted[i];
            let error = others[i] + difference * difference;
            // A comparison is one instruction for four texels, where `f32::min` is several: it has a
            // rule for NaN, of which there are none.
            least[i] = if error < least[i] { error } else { least[i] };
        }
    }
    // Four sums at a time, of which none waits for another.
    let sums: [f32; 4] =
        std::array::from_fn(|i| (least[i] + least[4 + i]) + (least[8 + i] + least[12 + i]));
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

fn refine<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    mut ends: [[u8; 2]; C],
) -> Fit<C> {
    let mut all: [Distances; C] =
        std::array::from_fn(|c| distances(&channels[c], &target.wanted[c], ends[c]));
    let mut best = f32::INFINITY;
    // Channels in a row, with that of the last better step, since which no step was better.
    let mut settled = 1;
    for _ in 0..MAX_ROUNDS {
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
                // A difference in the last bits is no improvement, and steps by it could cycle
                // forever.
                if error < best * (1.0 - 1e-6) {
                    best = error;
                    ends[c] = tried;
                    settled = 0;
                }
            }
            settled += 1;
            if settled > C {
                return Fit { ends, error: best };
            }
            all[c] = distances(channel, wanted, ends[c]);
        }
    }
    Fit { ends, error: best }
}

/// Endpoints at the extremes of the texels along an axis through their mean.
fn start<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    axis: &[f32; C],
    length: f32,
) -> [[u8; 2]; C] {
    let means = means(target);
    let mut range = [f32::INFINITY, f32::NEG_INFINITY];
    for i in 0..16 {
        let position: f32 = (0..C)
            .map(|c| (target.stored[c][i] - means[c]) * axis[c])
            .sum();
        range = [range[0].min(position), range[1].max(position)];
    }
    std::array::from_fn(|c| {
        let last = (channels[c].levels - 1) as f32;
        range.map(|position| {
            let value = means[c] + length * position * axis[c];
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
        // Power iteration needs a start that is not orthogonal to the axis; this one is unlikely to
        // be.
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
