//! Finds the changed rows of tables of entities.
//!
//! `Changed` in a query's filter tests each component of each entity by itself, which takes milliseconds for 100,000
//! meshes. Their ticks are contiguous in memory, and nearly always nothing has changed: here a block of them takes a
//! few vector instructions.
//!
//! No tick tells that a component was removed, or that an entity was disabled and enabled again, but then its row moves
//! to another table. [`MovedMeshes`] are those of such rows, whatever the component.

use std::ops::Range;

use bevy::{
    ecs::{
        change_detection::{ContiguousRef, Tick},
        entity::Entities,
    },
    prelude::*,
};

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
        ticks.fold(false, |any, tick| any | self.is_new(tick))
    }

    /// Sets the flags of those rows that have changed.
    fn flag_changed(&self, rows: Range<usize>, flags: &mut [bool]) {
        for (flag, tick) in flags.iter_mut().zip(&self.changed[rows]) {
            *flag |= self.is_new(tick);
        }
    }

    fn is_new(&self, tick: &Tick) -> bool {
        tick.is_newer_than(self.last_run, self.this_run)
    }
}

/// Calls a function with each of the first `count` rows of which a component in any of the columns has changed.
pub(super) fn for_each_changed_row(
    columns: &[Option<Column<'_>>],
    count: usize,
    mut f: impl FnMut(usize),
) {
    for start in (0..count).step_by(BLOCK) {
        let block = start..count.min(start + BLOCK);
        let mut flags = [false; BLOCK];
        for column in columns.iter().flatten() {
            if column.has_changed(block.clone()) {
                column.flag_changed(block.clone(), &mut flags);
            }
        }
        if flags != [false; BLOCK] {
            block.filter(|row| flags[row - start]).for_each(&mut f);
        }
    }
}

/// Whether rows are the same, in blocks without an early exit as above.
fn are_same(a: &[Entity], b: &[Entity]) -> bool {
    let pairs = |(a, b): (&[Entity], &[Entity])| {
        let pairs = a.iter().zip(b);
        pairs.fold(true, |all, (a, b)| all & (a.to_bits() == b.to_bits()))
    };
    a.len() == b.len() && a.chunks(BLOCK).zip(b.chunks(BLOCK)).all(pairs)
}

/// The entities in the rows of a query's tables, to find those that have come or gone.
#[derive(Default)]
struct KnownRows {
    /// By the number of the table, the entities in it, and whether the query has it now.
    tables: Vec<(Vec<Entity>, bool)>,
}

impl KnownRows {
    /// Takes over the rows of a table, and adds to `moved` the entities that were not in it, or are not any more.
    fn update(&mut self, rows: &[Entity], all: &Entities, moved: &mut Vec<Entity>) {
        let location = rows.first().and_then(|first| all.get_spawned(*first).ok());
        let Some(location) = location else {
            return;
        };
        let table = location.table_id.as_usize();
        if table >= self.tables.len() {
            self.tables.resize_with(table + 1, default);
        }
        let (known, is_there) = &mut self.tables[table];
        *is_there = true;
        if are_same(known, rows) {
            return;
        }
        for (before, now) in known.iter().zip(rows).filter(|(before, now)| before != now) {
            moved.extend([*before, *now]);
        }
        let common = known.len().min(rows.len());
        moved.extend(known[common..].iter().chain(&rows[common..]));
        known.clear();
        known.extend(rows);
    }

    /// To call after all tables: adds the entities of those that the query does not have any more.
    fn finish(&mut self, moved: &mut Vec<Entity>) {
        for (known, is_there) in &mut self.tables {
            if !*is_there {
                moved.append(known);
            }
            *is_there = false;
        }
    }
}

/// The meshes whose rows have moved in this frame: they have come or gone, or have got or lost a component.
#[derive(Resource, Default)]
pub(crate) struct MovedMeshes {
    rows: KnownRows,
    pub entities: Vec<Entity>,
}

/// Finds them, once for all that depends on the components of meshes.
pub(crate) fn find_moved_meshes(
    mut moved: ResMut<MovedMeshes>,
    meshes: Query<Entity, With<Mesh3d>>,
    all: &Entities,
) {
    let MovedMeshes {
        rows: known,
        entities,
    } = &mut *moved;
    entities.clear();
    if let Ok(tables) = meshes.contiguous_iter() {
        tables.for_each(|rows| known.update(rows, all, entities));
    } else {
        known.update(&meshes.iter().collect::<Vec<_>>(), all, entities);
    }
    known.finish(entities);
}

#[cfg(test)]
mod tests {
    use bevy::ecs::entity_disabling::Disabled;

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

    #[test]
    fn entities_that_come_and_go_are_found_whatever_the_cause() {
        let mut world = World::new();
        world.init_resource::<MovedMeshes>();
        let mut schedule = Schedule::default();
        schedule.add_systems(find_moved_meshes);
        let mut found = |world: &mut World| {
            schedule.run(world);
            let mut found = world.resource::<MovedMeshes>().entities.clone();
            found.sort_unstable_by_key(|entity| entity.index());
            found.dedup();
            found
        };
        let all: Vec<_> = (0..100)
            .map(|_| world.spawn(Mesh3d::default()).id())
            .collect();
        assert_eq!(found(&mut world), all);
        assert!(found(&mut world).is_empty());
        world.entity_mut(all[7]).insert(Disabled);
        // The last one is in its row now.
        assert_eq!(found(&mut world), [all[7], all[99]]);
        // One goes and another one comes, so there are as many.
        world.entity_mut(all[7]).remove::<Disabled>();
        world.entity_mut(all[98]).insert(Disabled);
        let moved = found(&mut world);
        assert!(
            moved.contains(&all[7]) && moved.contains(&all[98]),
            "{moved:?}"
        );
        for &entity in &all {
            world.entity_mut(entity).insert(Disabled);
        }
        assert_eq!(found(&mut world).len(), 99, "the table is empty");
        assert!(found(&mut world).is_empty());
        for &entity in &all {
            world.entity_mut(entity).remove::<Disabled>();
        }
        assert_eq!(found(&mut world), all);
        world.entity_mut(all[3]).insert(Other);
        world.despawn(all[4]);
        let moved = found(&mut world);
        assert!(
            moved.contains(&all[3]) && moved.contains(&all[4]),
            "{moved:?}"
        );
    }
}
