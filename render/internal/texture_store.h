// Textures of virtual objects on the device.
#pragma once

#include <map>
#include <memory>
#include <span>

#include "render/internal/gl_object.h"
#include "scene/texture.h"

namespace pleinair {

// Linear half floats: software's own decoding of sRGB is accurate to half a code only, and devices
// may filter before they decode. 8 bytes for each texel, and a third more for the levels.
class TextureStore {
 public:
  // Textures that are not in `wanted` are removed; the others are kept, so that a moving object
  // costs no upload.
  void Keep(std::span<const std::shared_ptr<const Texture>> wanted);

  // Binds to the active unit one that was wanted, uploading it when it is new: linear between the
  // texels of a level, the levels nearest. The finest levels are left out where the device takes
  // none of their size. Returns the last level. Throws std::runtime_error when the device has no
  // room for it.
  int Bind(const Texture& texture, const TextureWraps& wraps);

 private:
  struct Uploaded {
    std::shared_ptr<const Texture> texture;
    GlObject object;
    int last_level = 0;
  };

  std::map<const Texture*, Uploaded> uploaded_;
};

}  // namespace pleinair
