#include "render/internal/surface_textures.h"

#include <algorithm>
#include <cstddef>
#include <span>

namespace pleinair {
namespace {

// Fills `rect` with texel_of(layer, pixel), `pixel` an index in the picture.
template <typename Texel, typename TexelOf>
void Fill(StreamedTexture<Texel>& texture,
          const PixelRect& rect,
          int width,
          const TexelOf& texel_of) {
  texture.Fill(rect, [&](int layer, int y, std::span<Texel> texels) {
    std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(rect.lower.x);
    for (Texel& texel : texels) texel = texel_of(static_cast<std::size_t>(layer), pixel++);
  });
}

float FlagOf(const Gray8Image& flags, std::size_t pixel) {
  return !flags.Empty() && flags.pixels[pixel] != 0 ? 1.0f : 0.0f;
}

}  // namespace

PixelRect SurfaceTextures::Uploaded::Missing(const Uploaded& wanted) const {
  if (!wanted.state.IsSet() || state != wanted.state) return wanted.rect;
  const PixelRect both = UnionOf(rect, wanted.rect);
  // A part that grows is uploaded completely, so that it stays one rectangle.
  return both == rect ? PixelRect() : both;
}

void SurfaceTextures::Resize(const Size& size) {
  if (size == size_) return;
  const glm::ivec2 pixels(size.width, size.height);
  albedo_.Make(pixels);
  normal_.Make(pixels);
  sun_bounce_.Make(pixels);
  sun_visibility_.Make(pixels);
  sky_response_.Make(pixels, std::max(size.sky_shapes, 1));
  geometry_ = sky_ = sun_ = {};
  size_ = size;
}

void SurfaceTextures::Update(const SurfaceView& view, const PixelRect& wanted) {
  const int width = view.Width();
  Resize({width, view.Height(), static_cast<int>(view.sky_response.size())});
  // Recorded only after it has been uploaded: that may fail.
  const Uploaded geometry{view.geometry_id, wanted};
  PixelRect rect = geometry_.Missing(geometry);
  if (!rect.Empty()) {
    Fill(albedo_, rect, width, [&](std::size_t, std::size_t i) {
      return glm::vec4(view.albedo_rgb.pixels[i], FlagOf(view.albedo_measured, i));
    });
    Fill(normal_, rect, width, [&](std::size_t, std::size_t i) {
      return glm::vec4(view.normal_world.pixels[i], 0.0f);
    });
    geometry_ = {geometry.state, rect};
  }
  if (!view.sky_response.empty()) {
    const Uploaded sky{view.sky_id, wanted};
    rect = sky_.Missing(sky);
    if (!rect.Empty()) {
      Fill(sky_response_, rect, width, [&](std::size_t k, std::size_t i) {
        return glm::vec4(view.sky_response[k].pixels[i], 0.0f);
      });
      sky_ = {sky.state, rect};
    }
  }
  const Uploaded sun{view.sun_id, wanted};
  rect = sun_.Missing(sun);
  if (!rect.Empty()) {
    Fill(sun_visibility_, rect, width, [&](std::size_t, std::size_t i) {
      return glm::vec2(view.sun_visibility.pixels[i], view.edge_distance_px.pixels[i]);
    });
    Fill(sun_bounce_, rect, width, [&](std::size_t, std::size_t i) {
      return glm::vec4(view.sun_bounce.pixels[i], 0.0f);
    });
    sun_ = {sun.state, rect};
  }
}

void SurfaceTextures::UpdateCamera(const RgbImage& radiance,
                                   const Gray8Image& clipped,
                                   const PixelRect& rect) {
  const Size size{radiance.width, radiance.height, 0};
  if (!(size == camera_size_)) {
    camera_.Make({size.width, size.height});
    camera_size_ = size;
  }
  Fill(camera_, rect, size.width, [&](std::size_t, std::size_t i) {
    return glm::vec4(radiance.pixels[i], FlagOf(clipped, i));
  });
}

}  // namespace pleinair
