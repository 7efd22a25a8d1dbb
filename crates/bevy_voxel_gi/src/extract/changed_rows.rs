//! Finds the changed rows of tables of entities.
//!
//! `Changed` in a query's filter tests each component of each entity by itself, which takes milliseconds for 100,000
//! meshes. Their ticks are contiguous in memory, and nearly always nothing has changed: here a block of them takes a
//! few vector instructions.

use std::ops::Range;

use bevy::ecs::change_detection::{ContiguousRef, Tick};

/// Rows of which any tick is tested at once.
const BLOCK: usize = 64;

/// The ticks of a column of components.
pub(super) struct Column<'w> {
    changed: &'w [Tick],
    last_run: Tick,
    this_run: Tick,
}

/// Splits a column of a table into its components and their ticks; `None` if it is known that none has changed.
pub(super) fn split<'w, T>(column: ContiguousRef<'w, T>) -> (&'w [T], Option<Column<'w>>) {
    let (components, ticks) = ContiguousRef::split(column);
    let column = (ticks.summary_tick_is_changed() != Some(false)).then(|| Column {
        changed: ticks.changed(),
        last_run: ticks.last_run(),
        this_run: ticks.this_run(),
    });
    (components, column)
}

impl Column<'_> {
    /// Whether any of these rows has changed. Without an early exit, so that the compiler uses vector instructions.
    fn has_changed(&self, rows: Range<usize>) -> bool {
        let ticks = self.changed[rows].iter();
        ticks.fold(false, |any, tick| {
            any | tick.is_newer_than(self.last_run, self.this_run)
        })
    }
}

/// Calls a function with each of the first `count` rows of which a component in any of the columns has changed.
pub(super) fn for_each_changed_row(
    columns: &[Option<Column<'_>>],
    count: usize,
    mut f: impl FnMut(usize),
) {
    let has_changed = |rows: Range<usize>| {
        let mut columns = columns.iter().flatten();
        columns.any(|column| column.has_changed(rows.clone()))
    };
    for start in (0..count).step_by(BLOCK) {
        let block = start..count.min(start + BLOCK);
        if has_changed(block.clone()) {
            block
                .filter(|&row| has_changed(row..row + 1))
                .for_each(&mut f);
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::*;

    use super::*;

    #[derive(Component)]
    struct Number(usize);

    #[derive(Component)]
    #[component(summary_tick)]
    struct Counted(usize);

    #[derive(Component)]
    struct Other;

    #[derive(Resource, Default)]
    struct Found(Vec<usize>);

    fn find(
        numbers: Query<(Ref<Number>, Option<Ref<Counted>>), Without<Other>>,
        mut found: ResMut<Found>,
    ) {
        found.0.clear();
        for (numbers, counted) in numbers.contiguous_iter().expect("tables") {
            let (numbers, of_numbers) = split(numbers);
            let columns = [of_numbers, counted.and_then(|counted| split(counted).1)];
            for_each_changed_row(&columns, numbers.len(), |row| {
                found.0.push(numbers[row].0);
            });
        }
        found.0.sort_unstable();
    }

    #[test]
    fn exactly_the_changed_rows_are_found() {
        let mut world = World::new();
        world.init_resource::<Found>();
        let mut schedule = Schedule::default();
        schedule.add_systems(find);
        let mut found = |world: &mut World| {
            schedule.run(world);
            world.resource::<Found>().0.clone()
        };
        let spawned: Vec<_> = (0..300)
            .map(|i| match i % 3 {
                0 => world.spawn(Number(i)).id(),
                1 => world.spawn((Number(i), Counted(i))).id(),
                _ => world.spawn((Number(i), Other)).id(),
            })
            .collect();
        let of_query = |i: &usize| i % 3 != 2;
        assert_eq!(
            found(&mut world),
            (0..300).filter(of_query).collect::<Vec<_>>()
        );
        assert!(found(&mut world).is_empty());
        for i in [0, 63, 64, 150, 298] {
            world.get_mut::<Number>(spawned[i]).expect("it").0 = i;
        }
        world.get_mut::<Counted>(spawned[199]).expect("it").0 = 0;
        assert_eq!(found(&mut world), [0, 63, 64, 150, 199, 298]);
        assert!(found(&mut world).is_empty());
        world.entity_mut(spawned[5]).remove::<Other>();
        assert!(found(&mut world).is_empty(), "rows that moved are not new");
        world.entity_mut(spawned[6]).insert(Counted(6));
        assert_eq!(found(&mut world), [6]);
    }
}
