// A material as a file has it.
#pragma once

#include <string>

#include "scene/textured_material.h"

namespace pleinair {

struct SourceMaterial : TexturedMaterial {
  unsigned texture_set = 0;        // Which of a vertex' texture coordinates.
  std::string unreadable_texture;  // One that is wanted, and cannot be read; else empty.
};

}  // namespace pleinair
