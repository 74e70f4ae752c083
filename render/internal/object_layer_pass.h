// The virtual objects as a layer of their own: radiance times coverage, and coverage.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "render/internal/frame_buffer.h"
#include "render/internal/layer_reader.h"
#include "render/internal/rect_texture.h"
#include "render/internal/scene_geometry.h"
#include "render/internal/vertex_shares.h"
#include "render/internal/volume_stencil.h"
#include "scene/lighting.h"
#include "scene/mirrored_light.h"
#include "scene/state_id.h"
#include "scene/sun_shares.h"

namespace pleinair {

// The sun as the layer's shading wants it.
struct LayerSun {
  bool is_shining = false;
  glm::dvec3 to_sun{0.0, 0.0, 1.0};
  glm::vec3 irradiance{0.0f};  // In the layer's units.
  double angular_radius_rad = kMeanSunAngularRadiusRad;
  // Its shadow volumes; both null: no shadows.
  const ShadowVolumes* of_objects = nullptr;
  const ShadowVolumes* of_real = nullptr;
};

// Results of ray casting for the layer.
struct LayerLight {
  // Per object and vertex; empty: none.
  std::span<const std::vector<glm::vec3>> vertex_irradiance;
  // Share of the disc, a sample at a time; may be empty.
  const RectTexture<float>& seen_sun;
  // Light of glossy surfaces; null: they are diffuse.
  const MirroredLight* mirrored = nullptr;
  float gain = 1.0f;  // To the layer's units, of irradiance and of what is mirrored.
};

// Radiance of a point with diffuse albedo d, specular reflectance k and GGX width alpha, under
// irradiance E (from the vertices) and sun irradiance P from direction l:
//   L = d/pi E + M + s P max(0, n.l) (d/pi + GGX(k, alpha)) ,
// with n the shading normal, turned to the viewer. s is the visible share of the disc, or 0 in the
// shadow of any caster, and 0 where the triangle's visible side faces away. M is the light that a
// glossy surface mirrors; where that is not known, the surface is treated as diffuse, with min(d +
// k, 1). For materials by place, d and k are looked up for each sample, at the level of the texture
// whose texels are as wide as the sample. M uses the reflectance of the triangle.
//
// Edges  Several samples for each pixel, each with its own shading and shadow. They are drawn as a
//        larger, turned picture (see SampleLattice), but only for the rectangle with objects. In
//        software that costs half of multisampling.
// Kept   Where asked for, the samples are kept while neither camera nor geometry moves: their
//        depth, and the vertices' shares of each pixel, coloured by textures. New light is summed
//        with these shares, and only the sun is drawn for each frame. The layer is the same up to
//        rounding.
class ObjectLayerPass {
 public:
  // The lattice for `rect`. The side is as asked for, but less where an object in a large picture
  // would have more than 2^22 samples, and at least two.
  static SampleLattice LatticeOf(const PixelRect& rect, int wanted_side);

  // `keeps_samples` needs desktop OpenGL.
  ObjectLayerPass(int samples_per_side, bool keeps_samples);

  void Draw(const LayerView& view,
            SceneGeometry& scene,
            const LayerSun& sun,
            const LayerLight& light,
            VolumeStencil& stencil);

  // A layer without objects.
  void Clear(const glm::ivec2& size_px) { BeginLayer(size_px, {}); }

  // RGBA16F, RGBA32F where samples are kept; zero where no object is.
  const FrameBuffer& Layer() const { return layer_; }

 private:
  // The key of the samples in the buffer.
  struct KeptFor {
    StateId scene;
    glm::dmat4 clip_from_local{0.0};
    glm::ivec2 size_px{0};
    PixelRect rect;
    bool mirrors = false;  // Only of shares by place.
    bool operator==(const KeptFor&) const = default;
  };

  void BeginLayer(const glm::ivec2& size_px, const PixelRect& rect);
  void BindSamples();
  void DrawFromVertices(const LayerView& view,
                        SceneGeometry& scene,
                        const LayerLight& light,
                        const VolumeStencil& stencil);
  void FindShares(const LayerView& view,
                  SceneGeometry& scene,
                  const VolumeStencil& stencil,
                  bool mirrors);
  void SumFromVertices(const PixelRect& rect, SceneGeometry& scene, const LayerLight& light);
  void DrawSun(const LayerView& view,
               SceneGeometry& scene,
               const LayerSun& sun,
               const LayerLight& light,
               VolumeStencil& stencil);
  void DrawMean(const PixelRect& rect, bool has_samples);

  int wanted_samples_per_side_;
  bool keeps_samples_;
  SampleLattice lattice_;  // For the samples that are drawn.
  FrameBuffer samples_;
  FrameBuffer triangles_;  // Triangle indices of the samples, where these are kept.
  FrameBuffer layer_;
  std::optional<ShaderProgram> ambient_program_;   // Where samples are not kept.
  std::optional<ShaderProgram> triangle_program_;  // Where they are.
  ShaderProgram sun_program_;
  ShaderProgram mean_program_;
  // The same for materials by place; made when there is one.
  std::optional<ShaderProgram> ambient_by_place_;
  std::optional<ShaderProgram> triangle_by_place_;
  std::optional<ShaderProgram> sun_by_place_;
  GlObject no_vertices_;
  PixelRect drawn_rect_;
  std::vector<std::int8_t> sunlit_sides_;
  RectTexture<glm::vec4> mirrored_;
  // Where samples are kept.
  std::optional<KeptFor> kept_for_;
  VertexShares shares_;
  LayerReader reader_;
  std::vector<glm::vec3> at_vertices_;
  std::vector<glm::vec3> mirrored_at_pixels_;
  Image<glm::vec4> from_vertices_;
  RectTexture<glm::vec4> from_vertices_texture_;
};

}  // namespace pleinair
