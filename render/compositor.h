// Composites virtual objects into the camera's picture (differential rendering).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "objects/virtual_object.h"
#include "scene/camera.h"
#include "scene/exposure_motion.h"
#include "scene/image.h"
#include "scene/irradiance_change.h"
#include "scene/lighting.h"
#include "scene/mesh.h"
#include "scene/mirrored_light.h"
#include "scene/sun_shares.h"
#include "scene/surface_view.h"

namespace pleinair {

// Parts of the light that the compositor draws itself; other light comes with CompositeInput.
struct CompositeEffects {
  bool sun_shading = true;    // The sun on virtual objects.
  bool sun_shadow = true;     // Shadows of virtual objects on real surfaces.
  bool object_shadow = true;  // Shadows on virtual objects, of real casters and their own.
  bool probe_shading = true;  // Irradiance at the vertices.
};

// One frame's input. References live for the call only.
struct CompositeInput {
  const RgbImage& camera_radiance;  // Scene-linear, the view's size.
  const Gray8Image& clipped;  // 1 where the camera clipped, so that its value is a lower bound. May
                              // be empty: nothing was clipped.
  const SurfaceView& view;
  const Lighting& lighting;
  // Per object: irradiance at each vertex, sun's disc excluded (from the irradiance volume).
  std::span<const std::vector<glm::vec3>> vertex_irradiance;
  CompositeEffects effects;
  // Without the sun's shadow; inside the picture. Null: no change.
  const IrradianceChange* irradiance_change = nullptr;
  // Visible shares of the sun's disc, for lighting.sun's direction. Null: hard shadows, by volumes.
  const SunShares* sun_shares = nullptr;
  // Mirror images. Null: glossy objects are drawn as diffuse.
  const MirroredLight* mirrored = nullptr;
  // Standard deviation, 0 to 8, of the Gaussian blur of virtual objects and of the edges of
  // sun_shares' shadows: the camera's own blur (calib/edge_blur.h).
  float camera_blur_px = 0.0f;
  // Motion during the exposure: objects, their shadows and `irradiance_change` are means over that
  // time. Null: nothing moves.
  const MotionInPicture* motion = nullptr;
};

// The change of a pixel by the composite.
enum class PixelChange : std::uint8_t { kNone = 0, kScaled = 128, kCovered = 255 };

// The composite of one frame; images have the view's size.
struct Composite {
  // Scene-linear; kNone pixels are the camera's own, bit for bit. Changed ones are finite, and may
  // exceed the range of half floats: camera noise is added before ClampToHalf.
  RgbImage radiance;
  Gray8Image change;         // PixelChange values.
  double draw_ms = 0.0;      // Compositing by the processor included.
  double device_ms = 0.0;    // Part of draw_ms, by the device's own clock; 0 where the processor
                             // composites, and where the device has no such clock.
  double readback_ms = 0.0;  // Read-back of the device's picture, and copying.
  int draw_calls = 0;        // Passes over pixels by the processor in their place included.
};

// Where layers are composited into the camera's picture. Both ways use the same formulas; the
// device rounds to half floats.
enum class CompositeBy {
  kWhoeverIsFaster,  // The processor where it also draws for OpenGL.
  kDevice,
  kProcessor,
};

// Set-up of the compositor.
struct CompositorOptions {
  // Antialiasing of virtual objects: 2, 4, 6 or 8; its square plus one is the number of samples of
  // a pixel. Two is enough for distant objects. Where an object fills a large picture, a smaller
  // value is used.
  int object_samples_per_side = 4;
  CompositeBy composite_by = CompositeBy::kWhoeverIsFaster;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Draws into its own framebuffers of the context that was current at construction and must be
// current at each call. A real pixel in a new shadow, or whose other light changes by dE, is scaled
// by
//   (sky C + sun (s_with n.l + s_bounce) + dE) / (sky C + sun (s_without n.l + s_bounce))
// where it darkens, with s_with the share of the disc that is visible past real and virtual casters
// together. Where it brightens, it gains no more than a surface can reflect of the added light
// (relit_pixel.h). Where a pixel's own radiance is nearer to the shaded prediction than to the lit
// one, it has no sun to lose. The nearer the two predictions are to each other, and the farther the
// pixel is from the model's edges, the more the view's sun_visibility decides instead.
//
// Edges    An object's edge pixels blend with the camera's. Shadows by volumes are
//          hard; on real surfaces they are blurred over a pixel.
// Lens     For a camera with distortion, layers are drawn without it and looked up for each camera
//          pixel.
// Context  Leaves the application's framebuffer, viewport, pixel buffers and pixel layout
// (PixelStore)
//          as they were, and all tests switched off.
class Compositor {
 public:
  // Throws std::runtime_error when the context lacks something, naming it.
  explicit Compositor(const CompositorOptions& options = {});
  ~Compositor();
  Compositor(const Compositor&) = delete;
  Compositor& operator=(const Compositor&) = delete;

  // Real geometry: hides, receives, casts, is never drawn. Both throw std::invalid_argument naming
  // mesh and field for indices out of range, positions that are not finite, counts that do not
  // agree.
  void SetPhantom(const Mesh& mesh_world);
  // Virtual objects. Meshes may be open or non-manifold.
  void SetObjects(std::vector<VirtualObject> objects);

  // Returns the composite. Throws std::invalid_argument when sizes do not agree, naming them.
  // Throws std::runtime_error for a picture that the device cannot draw, and where the context is
  // not current or has been lost. After a loss, make a new context and a new compositor.
  Composite Render(const CompositeInput& input);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
