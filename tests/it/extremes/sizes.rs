//! Pictures and textures of every awkward size.

use super::stage::{ALL, app, difference, picture, switch};
use crate::support::gpu;

#[test]
fn pictures_of_any_size_are_bevys_own_but_for_a_little() {
    let _gpu = gpu();
    for size in [[1, 1], [1, 9], [9, 1], [2, 3], [33, 17], [257, 2]] {
        let mut app = app(size, [32, 32]);
        app.run_until_ready(200).expect("ready");
        let bevy = picture(&mut app, 1);
        // Without GI, which adds light.
        switch(app.world_mut(), [true, true, true, false]);
        app.run_until_ready(200).expect("ready");
        let ours = picture(&mut app, 1);
        let found = difference(&bevy, &ours);
        // A pixel alone has nobody to learn its colour from, and textures are filtered otherwise.
        println!("{size:?}: {found}");
        assert!(found < 0.2, "{size:?}: {found}");
        switch(app.world_mut(), ALL);
        app.run_until_ready(200).expect("ready");
        picture(&mut app, 3);
    }
}

#[test]
fn textures_of_any_size_are_bevys_own_but_for_a_little() {
    let _gpu = gpu();
    for texture in [
        [1, 1],
        [1, 64],
        [64, 1],
        [2, 2],
        [3, 5],
        [127, 33],
        [2048, 1],
    ] {
        let mut app = app([48, 32], texture);
        app.run_until_ready(200).expect("ready");
        let bevy = picture(&mut app, 1);
        // Without EWA: of textures so long and thin, Bevy's own filter leaves a blur.
        switch(app.world_mut(), [true, true, false, false]);
        app.run_until_ready(200).expect("ready");
        let found = difference(&bevy, &picture(&mut app, 1));
        println!("{texture:?}: {found}");
        assert!(found < 0.1, "{texture:?}: {found}");
        switch(app.world_mut(), ALL);
        app.run_until_ready(200).expect("ready");
        picture(&mut app, 3);
    }
}
