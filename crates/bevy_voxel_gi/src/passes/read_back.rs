//! Reads back what was counted on the GPU: slots, so that the buffers grow where these are too few, and what was
//! voxelised, for the report.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, MapMode},
        renderer::RenderDevice,
    },
};

use crate::prepare::buffers::VolumeBuffers;

/// A copy of the counts of this frame that is not read yet, and whether everything was voxelised.
#[derive(Resource, Default)]
pub(crate) struct CountsCopy(Option<(Buffer, bool)>);

impl CountsCopy {
    /// Copies the number of slots, then other counts from their places in other buffers.
    pub(super) fn record<'a>(
        &mut self,
        encoder: &mut CommandEncoder,
        buffers: &VolumeBuffers,
        batches: impl ExactSizeIterator<Item = (&'a Buffer, u64)>,
        is_whole: bool,
        device: &RenderDevice,
    ) {
        let copy = device.create_buffer(&BufferDescriptor {
            label: Some("voxel_gi_counts"),
            size: 4 + 4 * batches.len() as u64,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_buffer_to_buffer(&buffers.slot_lists, 0, &copy, 0, 4);
        for (i, (buffer, offset)) in (1..).zip(batches) {
            encoder.copy_buffer_to_buffer(buffer, offset, &copy, 4 * i, 4);
        }
        self.0 = Some((copy, is_whole));
    }
}

/// Asks for the copy of this frame; it arrives some frames later.
pub(crate) fn read_back(mut copy: ResMut<CountsCopy>, buffers: Option<Res<VolumeBuffers>>) {
    let (Some((copy, is_whole)), Some(buffers)) = (copy.0.take(), buffers) else {
        return;
    };
    let counts = buffers.counts.clone();
    copy.clone()
        .slice(..)
        .map_async(MapMode::Read, move |result| {
            if result.is_ok()
                && let Ok(bytes) = copy.slice(..).get_mapped_range()
                && let (words, []) = bytes.as_chunks()
                && let [slots, batches @ ..] = words
            {
                counts.raise_slots(u32::from_le_bytes(*slots), is_whole);
                let batches = batches.iter().map(|batches| u32::from_le_bytes(*batches));
                counts.set_batches(batches.sum());
            }
        });
}
