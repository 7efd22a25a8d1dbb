//! Search for the endpoints of a block on a line through `C` channels, by the error of the decoded
//! values.
//!
//! Each channel has a table of the values to which a pair of endpoints decodes at the four
//! positions on the line, in the units of the error. The search starts along a principal axis, clusters the texels by
//! their positions, and then moves endpoints by a step at a time.

/// The decoded values of all endpoints of one channel.
pub struct Channel {
    /// Number of values that an endpoint can have.
    levels: usize,
    /// Decoded values at the positions 0, 1/3, 2/3 and 1 on the line, or 0, 1/2, 1 and black, for each pair of
    /// endpoints.
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

    /// Endpoints after a step, where the channel has these levels.
    #[inline(always)]
    pub(super) fn moved(&self, ends: [u8; 2], step: [i16; 2]) -> Option<[u8; 2]> {
        let moved = [0, 1].map(|e| i16::from(ends[e]) + step[e]);
        let levels = 0..self.levels as i16;
        let is_inside = moved.iter().all(|end| levels.contains(end));
        is_inside.then(|| moved.map(|end| end as u8))
    }

    #[inline(always)]
    pub(super) fn palette(&self, [a, b]: [u8; 2]) -> &[f32; 4] {
        &self.table[a as usize * self.levels + b as usize]
    }
}

/// The values of a block that a fit approximates.
pub struct Target<const C: usize> {
    /// The values that the decoder should return, in the units of the error.
    pub expected: [[f32; 16]; C],
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
    /// Four starts: the same two on each of the first two principal axes, each of which is refined.
    Four,
}

/// Where a line starts and ends, between the outermost texels along an axis at 0 and 1.
const SPANS: [[f32; 2]; 2] = [[0.0, 1.0], [0.15, 0.85]];

/// Steps of a channel's two endpoints.
pub(super) const MOVES: [[i16; 2]; 12] = [
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

/// Largest number of rounds of steps, and of clusters.
const MAX_ROUNDS: usize = 16;

/// How much refining reduces an error at most, but for a few blocks.
const NEAR: f32 = 1.25;

/// Fits the endpoints of a block. Those that come nowhere near the error `most` are not refined. The result does not depend
/// on the processor.
pub fn fit<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    starts: Starts,
    most: f32,
) -> Fit<C> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        return unsafe { fit_with_avx2(channels, target, starts, most) };
    }
    fit_with_any(channels, target, starts, most)
}

/// Vectors of 8 texels in place of 4, which take two thirds of the time.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn fit_with_avx2<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    starts: Starts,
    most: f32,
) -> Fit<C> {
    fit_with_any(channels, target, starts, most)
}

#[inline(always)]
fn fit_with_any<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    starts: Starts,
    most: f32,
) -> Fit<C> {
    let spans = match starts {
        Starts::One => &SPANS[..1],
        Starts::Two | Starts::Four => &SPANS[..],
    };
    let axes = principal_axes(target);
    let axes = &axes[..if starts == Starts::Four { 2 } else { 1 }];
    let mut best: Option<Fit<C>> = None;
    for axis in axes {
        if starts != Starts::One
            && let Some(few) = Few::of(target, axis)
        {
            let found = few.fit(channels, target, start(channels, target, axis, SPANS[0]));
            if best.is_none_or(|best| found.error < best.error) {
                best = Some(found);
            }
            continue;
        }
        for span in spans {
            let mut found = cluster(channels, target, start(channels, target, axis, *span));
            if starts == Starts::Four {
                found = refine(channels, target, found);
            }
            if best.is_none_or(|best| found.error < best.error) {
                best = Some(found);
            }
        }
    }
    let best = best.expect("there is a start");
    if starts == Starts::Four || best.error > NEAR * most {
        best
    } else {
        refine(channels, target, best)
    }
}

/// The position on the line, 0 to 3, with the least error for each texel.
pub fn positions<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    ends: &[[u8; 2]; C],
) -> [u8; 16] {
    let sums = sum::<C>(&std::array::from_fn(|c| {
        distances(&channels[c], &target.expected[c], ends[c])
    }));
    nearest(&sums).1
}

/// Squared distance of each texel from each position on the line, in one channel.
type Distances = [[f32; 16]; 4];

#[inline(always)]
fn distances(channel: &Channel, expected: &[f32; 16], ends: [u8; 2]) -> Distances {
    channel
        .palette(ends)
        .map(|value| expected.map(|expected| (value - expected) * (value - expected)))
}

#[inline(always)]
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

/// The least distance of each texel, and the position that has it.
#[inline(always)]
fn nearest(sums: &Distances) -> ([f32; 16], [u8; 16]) {
    let (mut least, mut positions) = (sums[0], [0u32; 16]);
    for (position, sums) in sums.iter().enumerate().skip(1) {
        for i in 0..16 {
            let is_less = sums[i] < least[i];
            least[i] = if is_less { sums[i] } else { least[i] };
            positions[i] = if is_less {
                position as u32
            } else {
                positions[i]
            };
        }
    }
    (least, positions.map(|position| position as u8))
}

/// Four sums at a time, of which none waits for another.
#[inline(always)]
fn total(values: &[f32; 16]) -> f32 {
    let sums: [f32; 4] =
        std::array::from_fn(|i| (values[i] + values[4 + i]) + (values[8 + i] + values[12 + i]));
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Error of a channel with these endpoints, added to that of the `others`, with the best position
/// for each texel.
#[inline(always)]
fn error(others: &Distances, channel: &Channel, expected: &[f32; 16], ends: [u8; 2]) -> f32 {
    let mut least = [f32::INFINITY; 16];
    for (value, others) in channel.palette(ends).iter().zip(others) {
        for i in 0..16 {
            let difference = value - expected[i];
            let error = others[i] + difference * difference;
            // A comparison is one instruction for all texels of a vector, where `f32::min` is several: it has a
            // rule for NaN, of which there are none.
            least[i] = if error < least[i] { error } else { least[i] };
        }
    }
    total(&least)
}

/// Alternates between the best position for each texel and the best endpoints for these positions, which are found
/// without another look at the texels.
#[inline(always)]
fn cluster<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    ends: [[u8; 2]; C],
) -> Fit<C> {
    let mut best = Fit {
        ends,
        error: f32::INFINITY,
    };
    let mut tried = ends;
    for _ in 0..MAX_ROUNDS {
        let sums = sum::<C>(&std::array::from_fn(|c| {
            distances(&channels[c], &target.expected[c], tried[c])
        }));
        let (least, positions) = nearest(&sums);
        let error = total(&least);
        if error >= best.error * (1.0 - 1e-3) {
            break;
        }
        best = Fit { ends: tried, error };
        let there: Distances = std::array::from_fn(|position| {
            positions.map(|p| if p == position as u8 { 1.0 } else { 0.0 })
        });
        let counts = there.each_ref().map(total);
        for c in 0..C {
            let expected = &target.expected[c];
            let sums = there
                .each_ref()
                .map(|there| total(&std::array::from_fn(|i| there[i] * expected[i])));
            tried[c] = Clusters { counts, sums }.best_ends(&channels[c], tried[c]);
        }
        if tried == best.ends {
            break;
        }
    }
    best
}

/// The texels of a channel by their positions on the line: how many there are, and the sums of their values.
struct Clusters {
    counts: [f32; 4],
    sums: [f32; 4],
}

impl Clusters {
    /// The error of a pair of endpoints, but for a constant.
    #[inline(always)]
    fn error(&self, values: &[f32; 4]) -> f32 {
        let of: [f32; 4] =
            std::array::from_fn(|p| values[p] * (values[p] * self.counts[p] - 2.0 * self.sums[p]));
        (of[0] + of[1]) + (of[2] + of[3])
    }

    /// Endpoints near others with less error: a step by the least squares of the line's tangent, and single steps from
    /// there.
    #[inline(always)]
    fn best_ends(&self, channel: &Channel, ends: [u8; 2]) -> [u8; 2] {
        let last = channel.levels as i32 - 1;
        let values = channel.palette(ends);
        let mut best = (self.error(values), ends);
        // The slopes of the values by each endpoint.
        let slopes = [0, 1].map(|e: usize| {
            let mut beside = ends;
            let up = i32::from(ends[e]) < last;
            beside[e] = if up { ends[e] + 1 } else { ends[e] - 1 };
            let sign = if up { 1.0 } else { -1.0 };
            let moved = channel.palette(beside);
            std::array::from_fn::<f32, 4, _>(|p| sign * (moved[p] - values[p]))
        });
        let dot = |a: &[f32; 4], b: &[f32; 4]| -> f32 {
            let of: [f32; 4] = std::array::from_fn(|p| a[p] * b[p]);
            (of[0] + of[1]) + (of[2] + of[3])
        };
        let missing: [f32; 4] = std::array::from_fn(|p| self.sums[p] - self.counts[p] * values[p]);
        let weighted = slopes.map(|slope| std::array::from_fn(|p| self.counts[p] * slope[p]));
        let [aa, ab, bb] = [(0, 0), (0, 1), (1, 1)].map(|(a, b)| dot(&weighted[a], &slopes[b]));
        let [a, b] = slopes.each_ref().map(|slope| dot(slope, &missing));
        let determinant = aa * bb - ab * ab;
        if determinant > 1e-4 * aa * bb {
            let steps = [a * bb - b * ab, b * aa - a * ab].map(|v| v / determinant);
            let tried = [0, 1].map(|e: usize| {
                let end = f32::from(ends[e]) + steps[e];
                (end + 0.5).clamp(0.0, last as f32) as u8
            });
            let error = self.error(channel.palette(tried));
            if error < best.0 {
                best = (error, tried);
            }
        }
        for step in [[1, 0], [-1, 0], [0, 1], [0, -1]] {
            if let Some(tried) = channel.moved(best.1, step) {
                let error = self.error(channel.palette(tried));
                if error < best.0 {
                    best = (error, tried);
                }
            }
        }
        best.1
    }
}

/// The texels of a block that has no more than four colours, so that all ways to place these on a line can be tried: which
/// of them is best depends on how endpoints are rounded.
struct Few<const C: usize> {
    /// How many texels have each colour, and the colour, in their order along an axis.
    colors: [(f32, [f32; C]); 4],
    count: usize,
}

impl<const C: usize> Few<C> {
    #[inline(always)]
    fn of(target: &Target<C>, axis: &[f32; C]) -> Option<Self> {
        let mut colors = [(0.0, [0.0; C]); 4];
        let mut places = [0.0; 4];
        let mut count = 0;
        for i in 0..16 {
            let color: [f32; C] = std::array::from_fn(|c| target.expected[c][i]);
            if let Some(known) = colors[..count].iter_mut().find(|known| known.1 == color) {
                known.0 += 1.0;
                continue;
            }
            if count == 4 {
                return None;
            }
            let place: f32 = (0..C).map(|c| target.stored[c][i] * axis[c]).sum();
            let at = (0..count).find(|at| places[*at] > place).unwrap_or(count);
            colors[at..].rotate_right(1);
            places[at..].rotate_right(1);
            (colors[at], places[at]) = ((1.0, color), place);
            count += 1;
        }
        Some(Self { colors, count })
    }

    /// Tries all ways to place the colours in their order, from endpoints that are near them.
    #[inline(always)]
    fn fit(&self, channels: &[Channel; C], target: &Target<C>, near: [[u8; 2]; C]) -> Fit<C> {
        let mut best = cluster(channels, target, near);
        let mut placed = [0; 4];
        loop {
            let mut counts = [0.0; 4];
            let mut sums = [[0.0; 4]; C];
            for (position, (texels, color)) in placed.iter().zip(&self.colors[..self.count]) {
                counts[*position] += texels;
                for (sums, value) in sums.iter_mut().zip(color) {
                    sums[*position] += texels * value;
                }
            }
            let mut ends = near;
            for c in 0..C {
                let clusters = Clusters {
                    counts,
                    sums: sums[c],
                };
                for _ in 0..2 {
                    ends[c] = clusters.best_ends(&channels[c], ends[c]);
                }
            }
            let found = cluster(channels, target, ends);
            if found.error <= NEAR * best.error {
                let found = refine(channels, target, found);
                if found.error < best.error {
                    best = found;
                }
            }
            // The next way: the last position that can be raised, and all behind it with it.
            let Some(last) = placed[..self.count].iter().rposition(|p| *p < 3) else {
                return best;
            };
            let raised = placed[last] + 1;
            placed[last..].fill(raised);
        }
    }
}

/// Moves endpoints by a step at a time, with the best position for each texel after each step, until no step reduces the
/// error.
#[inline(always)]
fn refine<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    Fit {
        mut ends,
        error: mut best,
    }: Fit<C>,
) -> Fit<C> {
    let mut all: [Distances; C] =
        std::array::from_fn(|c| distances(&channels[c], &target.expected[c], ends[c]));
    // Channels in a row, with that of the last better step, since which no step was better.
    let mut settled = 1;
    for _ in 0..MAX_ROUNDS {
        for c in 0..C {
            let (channel, expected) = (&channels[c], &target.expected[c]);
            let own = std::mem::replace(&mut all[c], [[0.0; 16]; 4]);
            let others = sum(&all);
            all[c] = own;
            let before = ends[c];
            for step in MOVES {
                let Some(tried) = channel.moved(ends[c], step) else {
                    continue;
                };
                let error = error(&others, channel, expected, tried);
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
            if ends[c] != before {
                all[c] = distances(channel, expected, ends[c]);
            }
        }
    }
    Fit { ends, error: best }
}

/// Endpoints at a span of the texels along an axis through their mean.
#[inline(always)]
fn start<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    axis: &[f32; C],
    span: [f32; 2],
) -> [[u8; 2]; C] {
    let means = means(target);
    let mut range = [f32::INFINITY, f32::NEG_INFINITY];
    for i in 0..16 {
        let position: f32 = (0..C)
            .map(|c| (target.stored[c][i] - means[c]) * axis[c])
            .sum();
        range = [range[0].min(position), range[1].max(position)];
    }
    let ends = span.map(|at| range[0] + (range[1] - range[0]) * at);
    std::array::from_fn(|c| {
        let last = (channels[c].levels - 1) as f32;
        ends.map(|position| {
            let value = means[c] + position * axis[c];
            (value * last).round().clamp(0.0, last) as u8
        })
    })
}

#[inline(always)]
fn means<const C: usize>(target: &Target<C>) -> [f32; C] {
    std::array::from_fn(|c| target.stored[c].iter().sum::<f32>() / 16.0)
}

/// The first two principal axes of the stored texels, by power iteration.
#[inline(always)]
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

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Of as many values as a block of a photograph has, and of few.
        #[test]
        fn the_result_does_not_depend_on_the_processor(
            texels in prop::array::uniform16(prop::array::uniform3(0_u8..=255)),
            shift in 0_u32..8,
        ) {
            if !is_x86_feature_detected!("avx2") {
                return Ok(());
            }
            let channels: [Channel; 3] = [32, 64, 32].map(|levels| Channel::new(levels, |v| v * v));
            let stored: [[f32; 16]; 3] = std::array::from_fn(|c| {
                texels.map(|texel| f32::from(texel[c] >> shift << shift) / 255.0)
            });
            let expected = stored.map(|channel| channel.map(|v| v * v));
            let target = Target { expected, stored };
            for starts in [Starts::One, Starts::Two, Starts::Four] {
                let expected = fit_with_any(&channels, &target, starts, f32::INFINITY);
                // SAFETY: the processor has AVX2.
                let actual = unsafe { fit_with_avx2(&channels, &target, starts, f32::INFINITY) };
                prop_assert_eq!(actual.ends, expected.ends);
                prop_assert_eq!(actual.error.to_bits(), expected.error.to_bits());
            }
        }
    }
}
