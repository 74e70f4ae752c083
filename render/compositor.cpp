#include "render/compositor.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <epoxy/gl.h>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

#include "render/internal/blur_pass.h"
#include "render/internal/composite_pass.h"
#include "render/internal/current_context.h"
#include "render/internal/draw_count.h"
#include "render/internal/frame_buffer.h"
#include "render/internal/layer_lookup.h"
#include "render/internal/object_layer_pass.h"
#include "render/internal/real_shadow_pass.h"
#include "render/internal/rect_texture.h"
#include "render/internal/scene_geometry.h"
#include "render/internal/shadow_mask_pass.h"
#include "render/internal/surface_textures.h"
#include "render/internal/volume_stencil.h"

namespace pleinair {
namespace {

using Clock = std::chrono::steady_clock;

constexpr float kHalfMax = 65504.0f;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

template <typename Pixel>
void RequireSize(const Image<Pixel>& image, const SurfaceView& view, const char* name) {
  if (image.width == view.Width() && image.height == view.Height() &&
      image.pixels.size() == view.region.pixels.size()) {
    return;
  }
  throw std::invalid_argument(std::string(name) + " is " + SizeText(image.width, image.height) +
                              ", expected " + SizeText(view.Width(), view.Height()) +
                              ", the size of view.region");
}

template <typename Pixel>
void RequireInside(const Image<Pixel>& image,
                   const glm::ivec2& lower,
                   const SurfaceView& view,
                   const char* name) {
  if (lower.x >= 0 && lower.y >= 0 && lower.x + image.width <= view.Width() &&
      lower.y + image.height <= view.Height()) {
    return;
  }
  throw std::invalid_argument(std::string(name) + " of " + SizeText(image.width, image.height) +
                              " at (" + std::to_string(lower.x) + ", " + std::to_string(lower.y) +
                              "): expected inside the picture, " +
                              SizeText(view.Width(), view.Height()));
}

void ValidateCamera(const Camera& camera) {
  const CameraIntrinsics& intrinsics = camera.intrinsics;
  if (intrinsics.width_px < 1 || intrinsics.height_px < 1) {
    throw std::invalid_argument("camera picture is " +
                                SizeText(intrinsics.width_px, intrinsics.height_px) +
                                ", expected at least 1x1");
  }
  if (!(intrinsics.fx_px > 0.0) || !(intrinsics.fy_px > 0.0)) {
    throw std::invalid_argument("camera fx_px " + std::to_string(intrinsics.fx_px) + ", fy_px " +
                                std::to_string(intrinsics.fy_px) + ": expected both above 0");
  }
}

glm::dvec3 ValidatedDirection(const glm::dvec3& direction) {
  const double length = glm::length(direction);
  if (!(std::abs(length - 1.0) <= 1e-3)) {
    throw std::invalid_argument("sun direction has length " + std::to_string(length) +
                                ", expected a unit vector");
  }
  return direction / length;
}

void Validate(const CompositeInput& input, std::span<const VirtualObject> objects) {
  const SurfaceView& view = input.view;
  ValidateCamera(view.camera);
  if (view.camera.intrinsics.width_px != view.Width() ||
      view.camera.intrinsics.height_px != view.Height()) {
    throw std::invalid_argument(
        "view.region is " + SizeText(view.Width(), view.Height()) + ", expected the camera's " +
        SizeText(view.camera.intrinsics.width_px, view.camera.intrinsics.height_px));
  }
  RequireSize(input.camera_radiance, view, "camera_radiance");
  if (!input.clipped.Empty()) RequireSize(input.clipped, view, "clipped");
  RequireSize(view.albedo_rgb, view, "view.albedo_rgb");
  RequireSize(view.albedo_measured, view, "view.albedo_measured");
  RequireSize(view.normal_world, view, "view.normal_world");
  RequireSize(view.sun_visibility, view, "view.sun_visibility");
  RequireSize(view.sun_bounce, view, "view.sun_bounce");
  RequireSize(view.edge_distance_px, view, "view.edge_distance_px");
  for (const Image<glm::vec3>& response : view.sky_response) {
    RequireSize(response, view, "view.sky_response");
  }
  if (!(input.object_blur_px >= 0.0f && input.object_blur_px <= BlurPass::kMostPx)) {
    throw std::invalid_argument("object_blur_px is " + std::to_string(input.object_blur_px) +
                                ": expected 0 to 8 pixels");
  }
  if (view.sky_response.size() != input.lighting.sky.size()) {
    throw std::invalid_argument("lighting.sky has " + std::to_string(input.lighting.sky.size()) +
                                " shapes, view.sky_response " +
                                std::to_string(view.sky_response.size()) +
                                ": expected the same number");
  }
  if (view.sky_response.size() > static_cast<std::size_t>(CompositePass::kMaxSkyShapes)) {
    throw std::invalid_argument(
        "view.sky_response has " + std::to_string(view.sky_response.size()) +
        " shapes, expected at most " + std::to_string(CompositePass::kMaxSkyShapes));
  }
  if (input.irradiance_change != nullptr) {
    const IrradianceChange& change = *input.irradiance_change;
    RequireInside(change.irradiance_rgb, {change.x_px, change.y_px}, view, "irradiance_change");
  }
  if (input.sun_shares != nullptr) {
    const RealSunShare& real = input.sun_shares->real;
    RequireInside(real.hidden, {real.x_px, real.y_px}, view, "sun_shares.real");
  }
  if (!input.effects.probe_shading) return;
  if (input.vertex_irradiance.size() != objects.size()) {
    throw std::invalid_argument(
        "vertex_irradiance has " + std::to_string(input.vertex_irradiance.size()) +
        " entries, expected " + std::to_string(objects.size()) + ", one an object");
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (input.vertex_irradiance[i].size() != objects[i].mesh.positions_m.size()) {
      throw std::invalid_argument(
          "vertex_irradiance[" + std::to_string(i) + "] has " +
          std::to_string(input.vertex_irradiance[i].size()) + " entries, expected " +
          std::to_string(objects[i].mesh.positions_m.size()) + ", one a vertex of that object");
    }
  }
}

// The layers are half floats, with full precision from 6e-5 to 65504. A power of two brings the
// frame's brightest value near 2^4, so that radiances in any unit keep their digits, exactly, down
// to a quarter of a millionth of it; and a glint of the sun may be four thousand times as bright.
float LayerGain(const RgbImage& radiance, const Lighting& lighting) {
  // Bits of positive floats are ordered as the floats are, negative ones are below and what is not
  // finite is above, so that one integer maximum, which the compiler can vectorise, finds it.
  constexpr std::int32_t kInfinityBits = 0x7f800000;
  std::int32_t brightest_bits = 0;
  for (const glm::vec3& pixel : radiance.pixels) {
    for (int channel = 0; channel < 3; ++channel) {
      const auto bits = std::bit_cast<std::int32_t>(pixel[channel]);
      brightest_bits = std::max(brightest_bits, bits < kInfinityBits ? bits : 0);
    }
  }
  const auto brightest = std::bit_cast<float>(brightest_bits);
  const glm::dvec3 irradiance = lighting.sun.irradiance_rgb + lighting.SkyIrradianceRgb();
  const double from_light = std::max({irradiance.x, irradiance.y, irradiance.z}) / 3.14159265;
  const double peak = std::max(static_cast<double>(brightest), from_light);
  if (!(peak > 0.0) || !std::isfinite(peak)) return 1.0f;
  const int exponent = std::clamp(4 - std::ilogb(peak), -100, 100);
  return std::ldexp(1.0f, exponent);
}

// Reads `rect` of a frame buffer as RGBA half floats, in its own format where the device can.
class HalfReader {
 public:
  std::span<const std::uint16_t> Read(const FrameBuffer& frame, const PixelRect& rect) {
    const std::size_t count =
        4 * static_cast<std::size_t>(rect.Width()) * static_cast<std::size_t>(rect.Height());
    halves_.resize(count);
    frame.BindForReading();
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    GLint format = 0;
    GLint type = 0;
    glGetIntegerv(GL_IMPLEMENTATION_COLOR_READ_FORMAT, &format);
    glGetIntegerv(GL_IMPLEMENTATION_COLOR_READ_TYPE, &type);
    const bool reads_halves = epoxy_is_desktop_gl() || (format == GL_RGBA && type == GL_HALF_FLOAT);
    if (reads_halves) {
      glReadPixels(rect.lower.x,
                   rect.lower.y,
                   rect.Width(),
                   rect.Height(),
                   GL_RGBA,
                   GL_HALF_FLOAT,
                   halves_.data());
    } else {
      floats_.resize(count);
      glReadPixels(rect.lower.x,
                   rect.lower.y,
                   rect.Width(),
                   rect.Height(),
                   GL_RGBA,
                   GL_FLOAT,
                   floats_.data());
      for (std::size_t i = 0; i < count; ++i) halves_[i] = glm::packHalf1x16(floats_[i]);
    }
    return halves_;
  }

 private:
  std::vector<std::uint16_t> halves_;
  std::vector<float> floats_;
};

void RequireContext() {
  if (glGetString(GL_VERSION) == nullptr) {
    throw std::runtime_error("compositor: no OpenGL context is current on this thread");
  }
  const int version = epoxy_gl_version();
  const bool is_desktop = epoxy_is_desktop_gl();
  if (version < (is_desktop ? 45 : 31)) {
    throw std::runtime_error(std::string("compositor: this context is ") +
                             (is_desktop ? "OpenGL " : "OpenGL ES ") +
                             std::to_string(version / 10) + "." + std::to_string(version % 10) +
                             ", expected " + (is_desktop ? "4.5" : "3.1") + " or later");
  }
  if (!is_desktop && version < 32 && !epoxy_has_gl_extension("GL_EXT_color_buffer_half_float") &&
      !epoxy_has_gl_extension("GL_EXT_color_buffer_float")) {
    throw std::runtime_error(
        "compositor: this OpenGL ES context draws into no half floats: expected ES 3.2, "
        "GL_EXT_color_buffer_half_float or GL_EXT_color_buffer_float");
  }
}

// First member of Impl, so that it speaks before any shader is compiled.
struct CheckedContext {
  CheckedContext() { RequireContext(); }

  // Calls without a context would go nowhere, or end the program.
  void RequireCurrent() const {
    if (CurrentContext() == made_in) return;
    throw std::runtime_error(
        "compositor: the OpenGL context that it was made in is not current on this thread");
  }
  // A device that was reset or taken away draws nothing any more, and reads back anything.
  void RequireNotLost() const {
    if (tells_loss && glGetGraphicsResetStatus() != GL_NO_ERROR) {
      throw std::runtime_error(
          "compositor: the OpenGL context has been lost (the device was reset or taken away): "
          "expected to be made anew in another context");
    }
  }

  const void* made_in = CurrentContext();
  bool tells_loss = epoxy_gl_version() >= (epoxy_is_desktop_gl() ? 45 : 32);
};

}  // namespace

struct Compositor::Impl {
  explicit Impl(const CompositorOptions& options) : object_layer(options.object_samples_per_side) {}

  CheckedContext context;
  SceneGeometry scene;
  VolumeStencil stencil;
  ObjectLayerPass object_layer;
  std::optional<BlurPass> blur;  // Made when it is first wanted.
  RealShadowPass real_shadow;
  CompositePass composite;
  ShadowMaskPass shadow_mask;
  SurfaceTextures surface;
  RectTexture change;
  RectTexture hidden_sun;
  RectTexture seen_sun;  // In the objects' samples.
  RectTexture mirrored;
  LayerLookup lookup;
  HalfReader reader;

  // Kept while neither the camera nor the geometry moves.
  std::optional<Camera> layer_camera;
  std::uint64_t layer_version = 0;
  LayerView layer_view;
  // Kept while neither the sun nor the geometry moves.
  glm::dvec3 volumes_to_sun{0.0};
  std::uint64_t volumes_version = 0;
  ShadowVolumes object_volumes;
  ShadowVolumes real_volumes;

  void UpdateLayerView(const Camera& camera);
  void UpdateRects(const CompositeInput& input, bool has_shadows);
  void UpdateVolumes(const glm::dvec3& to_sun);
  PixelRect DrawLayers(const CompositeInput& input, float gain);
  void ReadBack(const RgbImage& camera, const PixelRect& rect, float gain, Composite& result);
};

void Compositor::Impl::UpdateLayerView(const Camera& camera) {
  if (layer_camera == camera && layer_version == scene.Version()) return;
  lookup.Update(camera.intrinsics);
  layer_view = MakeLayerView(scene, camera, lookup.Undistorted());
  layer_camera = camera;
  layer_version = scene.Version();
}

void Compositor::Impl::UpdateVolumes(const glm::dvec3& to_sun) {
  if (volumes_to_sun == to_sun && volumes_version == scene.Version()) return;
  scene.ObjectsAsCaster().BuildVolumes(to_sun, std::nullopt, object_volumes);
  scene.ObjectBuffers().UploadVolumes(object_volumes);
  // On real surfaces nature has drawn their shadows: they are wanted on the objects alone.
  scene.Phantom().BuildVolumes(to_sun, scene.ObjectBoxLocal(), real_volumes);
  scene.PhantomBuffers().UploadVolumes(real_volumes);
  volumes_to_sun = to_sun;
  volumes_version = scene.Version();
}

void Compositor::Impl::UpdateRects(const CompositeInput& input, bool has_shadows) {
  change.Clear();
  hidden_sun.Clear();
  seen_sun.Clear();
  mirrored.Clear();
  if (input.irradiance_change != nullptr) {
    const IrradianceChange& of_light = *input.irradiance_change;
    change.Update({of_light.x_px, of_light.y_px}, of_light.irradiance_rgb);
  }
  if (has_shadows && input.sun_shares != nullptr && input.effects.sun_shadow) {
    const RealSunShare& real = input.sun_shares->real;
    hidden_sun.Update({real.x_px, real.y_px}, real.hidden);
  }
  if (has_shadows && input.sun_shares != nullptr && input.effects.object_shadow) {
    const ObjectSunShare& objects = input.sun_shares->objects;
    seen_sun.Update(ObjectSunShare::kSamplesPerSide * glm::ivec2(objects.x_px, objects.y_px),
                    objects.seen);
  }
  if (input.mirrored != nullptr) {
    mirrored.Update({input.mirrored->x_px, input.mirrored->y_px}, input.mirrored->radiance);
  }
}

// Draws all layers and the composite; returns the part of the picture that may have changed.
PixelRect Compositor::Impl::DrawLayers(const CompositeInput& input, float gain) {
  const glm::dvec3 to_sun = ValidatedDirection(input.lighting.sun.direction_enu);
  const CompositeEffects& effects = input.effects;
  LayerSun sun;
  sun.to_sun = to_sun;
  sun.irradiance = glm::vec3(static_cast<double>(gain) * input.lighting.sun.irradiance_rgb);
  sun.angular_radius_rad = input.lighting.sun.angular_radius_rad;
  const bool has_sun = std::max({sun.irradiance.r, sun.irradiance.g, sun.irradiance.b}) > 0.0f;
  sun.is_shining = has_sun && effects.sun_shading;
  const bool has_shadows = has_sun && scene.ObjectBoxLocal().has_value() &&
                           (effects.sun_shadow || effects.object_shadow);

  const bool by_volumes = has_shadows && input.sun_shares == nullptr;
  PixelRect shadow_rect;  // In the layers, by volumes.
  if (by_volumes && effects.sun_shadow && scene.PhantomBoxLocal()) {
    shadow_rect = ShadowExtentOf(*scene.ObjectBoxLocal(),
                                 *scene.PhantomBoxLocal(),
                                 to_sun,
                                 layer_view.intrinsics,
                                 layer_view.camera_from_local);
  }
  const PixelRect& object_rect = layer_view.object_rect;
  UpdateRects(input, has_shadows);
  if (object_rect.Empty() && shadow_rect.Empty() && change.Rect().Empty() &&
      hidden_sun.Rect().Empty()) {
    return {};
  }

  const bool shades_objects =
      by_volumes && effects.object_shadow && sun.is_shining && !object_rect.Empty();
  if (shades_objects || !shadow_rect.Empty()) UpdateVolumes(to_sun);
  if (shadow_rect.Empty()) {
    real_shadow.Clear(layer_view.intrinsics.width_px, layer_view.intrinsics.height_px);
  } else {
    real_shadow.Draw(layer_view, shadow_rect, scene, object_volumes, to_sun, stencil);
  }
  scene.ShadedObjects().UploadIrradiance(
      effects.probe_shading ? input.vertex_irradiance : std::span<const std::vector<glm::vec3>>(),
      gain);
  object_layer.Draw(layer_view,
                    scene,
                    sun,
                    shades_objects ? &object_volumes : nullptr,
                    shades_objects ? &real_volumes : nullptr,
                    {seen_sun, mirrored, input.mirrored != nullptr, gain},
                    stencil);

  const float blur_px = input.object_blur_px;
  const int layer_width = layer_view.intrinsics.width_px;
  const int layer_height = layer_view.intrinsics.height_px;
  const bool is_blurred = blur_px > 0.0f && !object_rect.Empty();
  const PixelRect blurred_rect =
      is_blurred ? BlurPass::Spread(object_rect, blur_px, layer_width, layer_height) : object_rect;
  if (is_blurred) {
    if (!blur) blur.emplace();
    blur->Draw(object_layer.Layer(), object_rect, blur_px, layer_width, layer_height);
  }

  surface.Update(input.view);
  surface.UpdateCamera(input.camera_radiance, input.clipped);
  CompositeLight light;
  light.to_sun = to_sun;
  light.sun_irradiance = sun.irradiance;
  for (const SkyComponent& component : input.lighting.sky) {
    light.sky_irradiance.emplace_back(static_cast<double>(gain) * component.irradiance_rgb);
  }
  const CompositeLayers layers{surface,
                               lookup,
                               is_blurred ? blur->Layer() : object_layer.Layer(),
                               real_shadow.Mask(),
                               change,
                               hidden_sun,
                               lookup.CameraRectOf(blurred_rect),
                               lookup.CameraRectOf(shadow_rect)};
  composite.Draw(layers, light, gain, input.view.Width(), input.view.Height());
  return layers.Rect();
}

void Compositor::Impl::ReadBack(const RgbImage& camera,
                                const PixelRect& rect,
                                float gain,
                                Composite& result) {
  result.radiance = camera;
  result.change = Gray8Image(camera.width, camera.height, 0);
  if (rect.Empty()) return;
  const std::span<const std::uint16_t> halves = reader.Read(composite.Target(), rect);
  const float to_radiance = 1.0f / gain;
  const std::uint16_t* half = halves.data();
  for (int y = rect.lower.y; y < rect.upper.y; ++y) {
    for (int x = rect.lower.x; x < rect.upper.x; ++x, half += 4) {
      if (half[3] == 0) continue;
      const std::size_t pixel = result.radiance.Index(x, y);
      const glm::vec3 radiance(
          glm::unpackHalf1x16(half[0]), glm::unpackHalf1x16(half[1]), glm::unpackHalf1x16(half[2]));
      result.radiance.pixels[pixel] = glm::min(to_radiance * radiance, glm::vec3(kHalfMax));
      const bool is_covered = glm::unpackHalf1x16(half[3]) > 0.75f;
      result.change.pixels[pixel] =
          static_cast<std::uint8_t>(is_covered ? PixelChange::kCovered : PixelChange::kScaled);
    }
  }
}

void CompositorOptions::Validate() const {
  if (object_samples_per_side >= 2 && object_samples_per_side <= 8) return;
  throw std::invalid_argument("CompositorOptions::object_samples_per_side is " +
                              std::to_string(object_samples_per_side) + ": expected 2 to 8");
}

Compositor::Compositor(const CompositorOptions& options) {
  options.Validate();
  impl_ = std::make_unique<Impl>(options);
}

Compositor::~Compositor() = default;

void Compositor::SetPhantom(const Mesh& mesh_world) {
  impl_->context.RequireCurrent();
  impl_->scene.SetPhantom(mesh_world);
}

void Compositor::SetObjects(std::vector<VirtualObject> objects) {
  impl_->context.RequireCurrent();
  impl_->scene.SetObjects(std::move(objects));
}

Composite Compositor::Render(const CompositeInput& input) {
  impl_->context.RequireCurrent();
  Validate(input, impl_->scene.Objects());
  const ApplicationState application_state;
  Composite result;
  const Clock::time_point start = Clock::now();
  TakeDrawCount();
  const float gain = LayerGain(input.camera_radiance, input.lighting);
  impl_->UpdateLayerView(input.view.camera);
  const PixelRect rect = impl_->DrawLayers(input, gain);
  glFinish();
  result.draw_ms = MillisecondsSince(start);
  result.draw_calls = TakeDrawCount();
  const Clock::time_point drawn = Clock::now();
  impl_->ReadBack(input.camera_radiance, rect, gain, result);
  impl_->context.RequireNotLost();
  result.readback_ms = MillisecondsSince(drawn);
  return result;
}

Gray8Image Compositor::RenderShadowMask(const Camera& camera, const glm::dvec3& sun_direction_enu) {
  impl_->context.RequireCurrent();
  ValidateCamera(camera);
  if (camera.intrinsics.HasDistortion()) {
    throw std::invalid_argument(
        "shadow mask: the camera has lens distortion, expected one without");
  }
  const ApplicationState application_state;
  const LayerView view = MakeLayerView(impl_->scene, camera, camera.intrinsics);
  impl_->volumes_version = 0;  // The mask puts its own volumes into the buffers.
  return impl_->shadow_mask.Draw(
      view, impl_->scene, ValidatedDirection(sun_direction_enu), impl_->stencil);
}

}  // namespace pleinair
