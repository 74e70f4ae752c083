// Virtual objects into the camera's picture: the differential composite.
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

// What is drawn of the light beside what CompositeInput brings along.
struct CompositeEffects {
  bool sun_shading = true;    // The sun on virtual objects.
  bool sun_shadow = true;     // Of virtual objects on real surfaces.
  bool object_shadow = true;  // On virtual objects: of real casters and their own.
  bool probe_shading = true;  // Irradiance at the vertices.
};

// One frame's input. References live for the call only.
struct CompositeInput {
  const RgbImage& camera_radiance;  // Scene-linear, the view's size.
  const Gray8Image& clipped;  // 1 where the camera clipped: its value is a lower bound. May be
                              // empty: nothing was clipped.
  const SurfaceView& view;
  const Lighting& lighting;
  // Per object: irradiance at each vertex, sun's disc excluded (from the irradiance volume).
  std::span<const std::vector<glm::vec3>> vertex_irradiance;
  CompositeEffects effects;
  // Beside the sun's shadow; inside the picture. Null: nothing changes.
  const IrradianceChange* irradiance_change = nullptr;
  // Shares of the sun's disc for the shadows that are drawn, for lighting.sun's direction. Null:
  // hard shadows, by volumes.
  const SunShares* sun_shares = nullptr;
  // Null: drawn as diffuse.
  const MirroredLight* mirrored = nullptr;
  // Standard deviation of the Gaussian that virtual objects and the edges of sun_shares' shadows
  // are blurred by, as the camera blurs what is real (calib/edge_blur.h); 0 to 8.
  float camera_blur_px = 0.0f;
  // What moves while the frame is exposed: objects, their shadows and `irradiance_change` are means
  // over that time. Null: all stand still.
  const MotionInPicture* motion = nullptr;
};

// What the composite did to each pixel.
enum class PixelChange : std::uint8_t { kNone = 0, kScaled = 128, kCovered = 255 };

struct Composite {
  // Scene-linear; kNone pixels are the camera's own, bit for bit. Changed ones are finite, and may
  // be beyond what a half float holds (ClampToHalf): camera noise comes first.
  RgbImage radiance;
  Gray8Image change;         // PixelChange values.
  double draw_ms = 0.0;      // What the processor composites included.
  double readback_ms = 0.0;  // Of what the device composites, and of copying the picture.
  int draw_calls = 0;        // And passes over pixels that the processor made in their place.
};

// Who puts layers into the camera's picture. Both do it by the same formulas; the device rounds to
// half floats.
enum class CompositeBy {
  kWhoeverIsFaster,  // The processor where it draws for OpenGL too.
  kDevice,
  kProcessor,
};

struct CompositorOptions {
  // How smooth edges on and of virtual objects are: 2, 4, 6 or 8; its square and one is the number
  // of samples of a pixel. Two is enough for who looks from afar; where an object fills a large
  // picture less than asked for is taken.
  int object_samples_per_side = 4;
  CompositeBy composite_by = CompositeBy::kWhoeverIsFaster;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Draws into its own framebuffers of the context that was current at construction and has to be
// current at each call. A real pixel in a new shadow, or whose other light changes by dE, is scaled
// by
//   (sky C + sun (s_with n.l + s_bounce) + dE) / (sky C + sun (s_without n.l + s_bounce))
// with s_with the disc seen past real and virtual casters together, where it darkens; where it
// brightens it gains no more than a surface can reflect of what is added (relit_pixel.h). Where a
// pixel's own radiance is nearer to the shaded prediction than to the lit one there is no sun to
// take away; the nearer the two predictions are to each other, and the farther the pixel is from
// the model's edges, the more the view's sun_visibility decides instead.
//
// Edges    An object's edge pixels blend with the camera's. Shadows by volumes are
//          hard; on real surfaces they are blurred over a pixel.
// Lens     Where the camera distorts, layers are drawn without and looked up per camera pixel.
// Context  Leaves the application's framebuffer and viewport bound, and all tests switched off.
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

  // Throws std::invalid_argument when sizes do not agree, naming them; std::runtime_error for a
  // picture that the device cannot draw, and where the context is not current or has been lost:
  // then a new context and a new compositor are what helps.
  Composite Render(const CompositeInput& input);

  // The hard sun shadow on whatever is nearest in each pixel of an undistorted camera, phantom and
  // objects together: 255 in shadow, 0 lit or facing away or empty. For tests and other renderers.
  Gray8Image RenderShadowMask(const Camera& camera, const glm::dvec3& sun_direction_enu);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
