// Which pairs of geoms MuJoCo's collision detection looks at closely.
#pragma once

#include <mujoco/mujoco.h>

namespace primo::physics {

/// Whether an axis of either geom, or the line between their centres, shows that they are further apart than their
/// contact margin. False is no statement: they may touch or not. Planes and shapes other than spheres, capsules,
/// cylinders and boxes: by their bounding spheres, or false. @pre positions are up to date
bool surely_apart(const mjModel* model, const mjData* data, int geom_a, int geom_b);

/// Makes all simulations of this process skip pairs that are surely apart: MuJoCo 2.2 itself compares bounding spheres
/// only, and that of a table holds all that is near it. Contacts are the same, to the bit. Safe from any thread.
void use_contact_filter();

}  // namespace primo::physics
