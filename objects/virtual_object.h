// Objects that are drawn into the picture.
#pragma once

#include "scene/mesh.h"

namespace pleinair {

// Materials are drawn with their diffuse albedo and the sun's GGX highlight. What a glossy surface
// mirrors of its surroundings is computed separately (mirror_image.h). Without that the surface is
// drawn as diffuse, with albedo plus specular reflectance.
struct VirtualObject {
  Mesh mesh;  // In world coordinates. Needs normals.
};

}  // namespace pleinair
