//! Pictures and textures of every awkward size.

use super::stage::{ALL, app, difference, picture, switch};
use crate::support::gpu;

#[test]
fn pictures_of_any_size_are_bevys_own_but_for_a_little() {
    let _gpu = gpu();
    // A pixel alone has no neighbour to take its chrominance from, and EWA filters textures otherwise.
    for (size, most) in [
        ([1, 1], 0.19),
        ([1, 9], 0.042),
        ([9, 1], 0.021),
        ([2, 3], 0.016),
        ([33, 17], 0.097),
        ([257, 2], 0.0003),
    ] {
        let mut app = app(size, [32, 32]);
        app.run_until_ready(200).expect("ready");
        let bevy = picture(&mut app, 1);
        // Without GI, which adds light.
        switch(app.world_mut(), [true, true, true, false]);
        app.run_until_ready(200).expect("ready");
        let ours = picture(&mut app, 1);
        let actual = difference(&bevy, &ours);
        println!("{size:?}: {actual}");
        assert!(actual < most, "{size:?}: {actual}");
        switch(app.world_mut(), ALL);
        app.run_until_ready(200).expect("ready");
        picture(&mut app, 3);
    }
}

#[test]
fn textures_of_any_size_are_bevys_own_but_for_a_little() {
    let _gpu = gpu();
    for (texture, most) in [
        ([1, 1], 0.001),
        ([1, 64], 0.055),
        ([64, 1], 0.09),
        ([2, 2], 0.001),
        ([3, 5], 0.013),
        ([127, 33], 0.012),
        ([2048, 1], 0.006),
    ] {
        let mut app = app([48, 32], texture);
        app.run_until_ready(200).expect("ready");
        let bevy = picture(&mut app, 1);
        // Without EWA: of textures so long and thin, Bevy's own filter leaves a blur.
        switch(app.world_mut(), [true, true, false, false]);
        app.run_until_ready(200).expect("ready");
        let actual = difference(&bevy, &picture(&mut app, 1));
        println!("{texture:?}: {actual}");
        assert!(actual < most, "{texture:?}: {actual}");
        switch(app.world_mut(), ALL);
        app.run_until_ready(200).expect("ready");
        picture(&mut app, 3);
    }
}
