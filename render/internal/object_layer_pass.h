// The virtual objects as a layer of their own: radiance times coverage, and coverage.
#pragma once

#include <glm/vec3.hpp>

#include "render/internal/frame_buffer.h"
#include "render/internal/rect_texture.h"
#include "render/internal/scene_geometry.h"
#include "render/internal/volume_stencil.h"
#include "scene/lighting.h"
#include "scene/sun_shares.h"

namespace pleinair {

// The sun as the layer's shading wants it.
struct LayerSun {
  bool is_shining = false;
  glm::dvec3 to_sun{0.0, 0.0, 1.0};
  glm::vec3 irradiance{0.0f};  // In the layer's units.
  double angular_radius_rad = kMeanSunAngularRadiusRad;
};

// What ray casting says of the layer; either may be empty.
struct LayerLight {
  const RectTexture& seen_sun;  // Share of the disc, a sample at a time.
  const RectTexture& mirrored;  // Radiance, a pixel at a time.
  bool mirrors = false;         // Glossy surfaces send what `mirrored` holds, or nothing.
  float gain = 1.0f;            // From `mirrored` to the layer's units.
};

// Radiance of a point with diffuse albedo d, specular reflectance k and GGX width alpha, under
// irradiance E (from the vertices) and sun irradiance P from direction l:
//   L = d/pi E + M + s P max(0, n.l) (d/pi + GGX(k, alpha)) ,
// n the shading normal, turned to the viewer; s is the share of the disc seen, or 0 in the shadow
// of any caster, and 0 where the triangle's visible side faces away. M is what a glossy surface
// mirrors of its surroundings; where that is not known, the surface is taken for diffuse, with
// min(d + k, 1).
//
// Edges  Several samples a pixel, each shaded and shadowed by itself: drawn larger, but only the
//        rectangle that holds objects. In software that costs half of what multisampling does.
class ObjectLayerPass {
 public:
  // Samples of a side of each pixel of `rect`: as many as asked for, fewer where an object fills
  // that much of a large picture that more than 2^22 samples would come out, but two at least.
  static int SamplesPerSide(const PixelRect& rect, int wanted);

  explicit ObjectLayerPass(int samples_per_side);

  // `casters_on_objects`: volumes of the real scene; both sets may be null: no shadows.
  void Draw(const LayerView& view,
            SceneGeometry& scene,
            const LayerSun& sun,
            const ShadowVolumes* object_volumes,
            const ShadowVolumes* real_volumes,
            const LayerLight& light,
            VolumeStencil& stencil);

  // RGBA16F, zero where no object is.
  GLuint Layer() const { return layer_.ColourTexture(); }

 private:
  void DrawSamples(const LayerView& view,
                   SceneGeometry& scene,
                   const LayerSun& sun,
                   const ShadowVolumes* object_volumes,
                   const ShadowVolumes* real_volumes,
                   const LayerLight& light,
                   VolumeStencil& stencil);

  int wanted_samples_per_side_;
  FrameBuffer samples_;
  FrameBuffer layer_;
  ShaderProgram ambient_program_;
  ShaderProgram sun_program_;
  ShaderProgram mean_program_;
  GlObject no_vertices_;
  PixelRect drawn_rect_;
  std::vector<std::int8_t> sunlit_sides_;
};

}  // namespace pleinair
