//! Reads back how many slots the faces need, so that the buffers grow where they are too small.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, MapMode},
        renderer::RenderDevice,
    },
};

use crate::prepare::buffers::VolumeBuffers;

/// A copy of the number of slots that is not read yet, and whether everything was voxelised.
#[derive(Resource, Default)]
pub(crate) struct SlotDemandCopy(Option<(Buffer, bool)>);

impl SlotDemandCopy {
    /// Copies the number.
    pub(super) fn record(
        &mut self,
        encoder: &mut CommandEncoder,
        buffers: &VolumeBuffers,
        is_whole: bool,
        device: &RenderDevice,
    ) {
        let copy = device.create_buffer(&BufferDescriptor {
            label: Some("voxel_gi_slot_demand"),
            size: 4,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_buffer_to_buffer(&buffers.slot_lists, 0, &copy, 0, 4);
        self.0 = Some((copy, is_whole));
    }
}

/// Asks for the copy of this frame; it arrives some frames later.
pub(crate) fn read_back(mut copy: ResMut<SlotDemandCopy>, buffers: Option<Res<VolumeBuffers>>) {
    let (Some((copy, is_whole)), Some(buffers)) = (copy.0.take(), buffers) else {
        return;
    };
    let demand = buffers.slot_demand.clone();
    copy.clone()
        .slice(..)
        .map_async(MapMode::Read, move |result| {
            if result.is_ok()
                && let Ok(bytes) = copy.slice(..).get_mapped_range()
                && let Some(bytes) = bytes.first_chunk()
            {
                demand.raise(u32::from_le_bytes(*bytes), is_whole);
            }
        });
}
