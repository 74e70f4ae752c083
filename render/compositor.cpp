#include "render/compositor.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <epoxy/gl.h>
#include <tbb/parallel_for.h>
#include <glm/gtc/packing.hpp>

#include "render/internal/blur_pass.h"
#include "render/internal/checked_context.h"
#include "render/internal/composite_input.h"
#include "render/internal/composite_pass.h"
#include "render/internal/device_timer.h"
#include "render/internal/draw_count.h"
#include "render/internal/frame_buffer.h"
#include "render/internal/layer_lookup.h"
#include "render/internal/layer_reader.h"
#include "render/internal/motion_blur.h"
#include "render/internal/object_layer_pass.h"
#include "render/internal/processor_composite.h"
#include "render/internal/real_shadow_pass.h"
#include "render/internal/rect_texture.h"
#include "render/internal/scene_geometry.h"
#include "render/internal/surface_textures.h"
#include "render/internal/volume_stencil.h"
#include "scene/state_id.h"

namespace pleinair {
namespace {

using Clock = std::chrono::steady_clock;

// As integers, the bits of positive floats have the order of the floats; negative floats are below
// and non-finite ones above. So one integer maximum, which the compiler can vectorise, finds the
// largest.
float LargestFinite(std::span<const glm::vec3> values) {
  constexpr std::int32_t kInfinityBits = 0x7f800000;
  std::int32_t largest_bits = 0;
  for (const glm::vec3& value : values) {
    for (int channel = 0; channel < 3; ++channel) {
      const auto bits = std::bit_cast<std::int32_t>(value[channel]);
      largest_bits = std::max(largest_bits, bits < kInfinityBits ? bits : 0);
    }
  }
  return std::bit_cast<float>(largest_bits);
}

// Radiance of white.
double PeakOf(const Lighting& lighting) {
  const glm::dvec3 irradiance = lighting.sun.irradiance_rgb + lighting.SkyIrradianceRgb();
  return std::max({irradiance.x, irradiance.y, irradiance.z}) * std::numbers::inv_pi;
}

// The brightest except for one in a thousand: a hot pixel must not cost the others precision.
double PeakOf(const RgbImage& radiance) {
  constexpr std::size_t kAsked = 20000;
  const std::size_t stride = std::max<std::size_t>(radiance.pixels.size() / kAsked, 1);
  std::vector<float> asked;
  for (std::size_t i = 0; i < radiance.pixels.size(); i += stride) {
    asked.push_back(LargestFinite({&radiance.pixels[i], 1}));
  }
  if (asked.empty()) return 0.0;
  const auto brightest = asked.begin() + static_cast<std::ptrdiff_t>(asked.size() * 999 / 1000);
  std::nth_element(asked.begin(), brightest, asked.end());
  return double{*brightest};
}

double PeakOnObjects(const CompositeInput& input) {
  double peak = 0.0;
  for (const std::vector<glm::vec3>& irradiance : input.vertex_irradiance) {
    peak = std::max(peak, std::numbers::inv_pi * LargestFinite(irradiance));
  }
  return peak;
}

// The layers are half floats, with full precision from 6e-5 to 65504. Scaling by a power of two,
// which is exact, puts their brightest value near 2^4. So radiances in any unit keep their digits
// down to a quarter of a millionth of it, and a glint of the sun may be four thousand times as
// bright.
float LayerGain(double peak_of_light, double peak_of_pictures) {
  const double peak = std::max(peak_of_light, peak_of_pictures);
  if (!(peak > 0.0) || !std::isfinite(peak)) return 1.0f;
  const int exponent = std::clamp(4 - std::ilogb(peak), -100, 100);
  return std::ldexp(1.0f, exponent);
}

}  // namespace

struct Compositor::Impl {
  explicit Impl(const CompositorOptions& options)
      : by_processor(
            options.composite_by == CompositeBy::kProcessor ||
            (options.composite_by == CompositeBy::kWhoeverIsFaster && context.DrawsInSoftware())),
        object_layer(options.object_samples_per_side, by_processor && epoxy_is_desktop_gl()),
        moved_layer("objects in motion",
                    by_processor && epoxy_is_desktop_gl() ? GL_RGBA32F : GL_RGBA16F,
                    FrameBuffer::DepthStencil::kNone) {
    if (!by_processor) device.emplace();
  }

  // The composite on the device.
  struct OnDevice {
    CompositePass composite;
    SurfaceTextures surface;
    RectTexture<glm::vec4> change;
    RectTexture<float> hidden_sun;
    DeviceTimer timer;
  };

  CheckedContext context;
  bool by_processor;
  SceneGeometry scene;
  VolumeStencil stencil;
  ObjectLayerPass object_layer;
  FrameBuffer moved_layer;       // The objects' over the exposure, where something moves.
  std::optional<BlurPass> blur;  // Made when it is first wanted.
  RealShadowPass real_shadow;
  std::optional<OnDevice> device;
  RectTexture<float> seen_sun;  // In the objects' samples.
  LayerLookup lookup;
  LayerReader reader;

  // Kept while neither the camera nor the geometry moves.
  std::optional<Camera> layer_camera;
  StateId layer_of_scene;
  LayerView layer_view;
  // Kept while neither the sun nor the geometry moves.
  glm::dvec3 volumes_to_sun{0.0};
  StateId volumes_of_scene;
  ShadowVolumes object_volumes;
  ShadowVolumes real_volumes;

  // The content of a frame's layers.
  struct Drawn {
    const FrameBuffer* objects = nullptr;
    PixelRect object_rect;  // In the layers.
    PixelRect shadow_rect;  // In the layers, of shadows by volumes.
    const RealSunShare* hidden_sun = nullptr;
    // Over the exposure, where something moves.
    std::optional<RealSunShare> moved_sun;
    std::optional<IrradianceChange> moved_change;
  };

  void UpdateLayerView(const Camera& camera);
  void UpdateVolumes(const glm::dvec3& to_sun);
  Drawn DrawLayers(const CompositeInput& input, const glm::dvec3& to_sun, float gain);
  void MoveLayers(const CompositeInput& input, const glm::dvec3& to_sun, Drawn& drawn);
  LayerPart<float> ReadMask(const PixelRect& rect);
  BlurKernel LayerBlur(float camera_blur_px) const;
  PixelRect CompositeOnDevice(const CompositeInput& input,
                              const Drawn& drawn,
                              const CompositeLight& light,
                              float gain);
  void ReadBack(const PixelRect& rect, float gain, Composite& result);
  void CompositeInMemory(const CompositeInput& input,
                         const Drawn& drawn,
                         const CompositeLight& light,
                         float gain,
                         Composite& result);
};

void Compositor::Impl::UpdateLayerView(const Camera& camera) {
  if (layer_camera == camera && layer_of_scene == scene.Id()) return;
  lookup.Update(camera.intrinsics);
  layer_view = MakeLayerView(scene, camera, lookup.Undistorted());
  layer_camera = camera;
  layer_of_scene = scene.Id();
}

// A layer that is looked up between its pixels is blurred by that already.
BlurKernel Compositor::Impl::LayerBlur(float camera_blur_px) const {
  // Mean of f (1 - f) for f uniform in [0, 1].
  constexpr double kMeanVarianceOfLookups = 1.0 / 6.0;
  return lookup.IsIdentity() ? BlurKernel(camera_blur_px)
                             : BlurKernel::AfterBlur(camera_blur_px, kMeanVarianceOfLookups);
}

void Compositor::Impl::UpdateVolumes(const glm::dvec3& to_sun) {
  if (volumes_to_sun == to_sun && volumes_of_scene == scene.Id()) return;
  scene.ObjectsAsCaster().BuildVolumes(to_sun, std::nullopt, object_volumes);
  scene.ObjectBuffers().UploadVolumes(object_volumes);
  // On real surfaces nature has drawn their shadows: they are wanted on the objects alone.
  scene.Phantom().BuildVolumes(to_sun, scene.ObjectBoxLocal(), real_volumes);
  scene.PhantomBuffers().UploadVolumes(real_volumes);
  volumes_to_sun = to_sun;
  volumes_of_scene = scene.Id();
}

Compositor::Impl::Drawn Compositor::Impl::DrawLayers(const CompositeInput& input,
                                                     const glm::dvec3& to_sun,
                                                     float gain) {
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
  const bool by_shares = has_shadows && input.sun_shares != nullptr;
  Drawn drawn;
  if (by_volumes && effects.sun_shadow && scene.PhantomBoxLocal()) {
    drawn.shadow_rect = ShadowExtentOf(*scene.ObjectBoxLocal(),
                                       *scene.PhantomBoxLocal(),
                                       to_sun,
                                       layer_view.intrinsics,
                                       layer_view.camera_from_local);
  }
  if (by_shares && effects.sun_shadow && !input.sun_shares->real.hidden.Empty()) {
    drawn.hidden_sun = &input.sun_shares->real;
  }
  const PixelRect& object_rect = layer_view.object_rect;
  const bool shades_objects =
      by_volumes && effects.object_shadow && sun.is_shining && !object_rect.Empty();
  if (shades_objects || !drawn.shadow_rect.Empty()) UpdateVolumes(to_sun);
  if (!drawn.shadow_rect.Empty()) {
    real_shadow.Draw(layer_view, drawn.shadow_rect, scene, {object_volumes, to_sun}, stencil);
  }
  if (object_rect.Empty()) {
    if (input.motion != nullptr) MoveLayers(input, to_sun, drawn);
    return drawn;
  }

  seen_sun.Clear();
  if (by_shares && effects.object_shadow) {
    const ObjectSunShare& objects = input.sun_shares->objects;
    seen_sun.Update(ObjectSunShare::kSamplesPerSide * glm::ivec2(objects.x_px, objects.y_px),
                    objects.seen);
  }
  if (shades_objects) {
    sun.of_objects = &object_volumes;
    sun.of_real = &real_volumes;
  }
  object_layer.Draw(
      layer_view,
      scene,
      sun,
      {effects.probe_shading ? input.vertex_irradiance : std::span<const std::vector<glm::vec3>>(),
       seen_sun,
       input.mirrored,
       gain},
      stencil);
  drawn.objects = &object_layer.Layer();
  drawn.object_rect = object_rect;
  if (input.motion != nullptr) MoveLayers(input, to_sun, drawn);
  const BlurKernel kernel = LayerBlur(input.camera_blur_px);
  if (!kernel.IsNone()) {
    const int width = layer_view.intrinsics.width_px;
    const int height = layer_view.intrinsics.height_px;
    if (!blur) blur.emplace();
    blur->Draw(drawn.objects->ColourTexture(), drawn.object_rect, kernel, width, height);
    drawn.objects = &blur->Layer();
    drawn.object_rect = kernel.Spread(drawn.object_rect, width, height);
  }
  return drawn;
}

LayerPart<float> Compositor::Impl::ReadMask(const PixelRect& rect) {
  LayerPart<float> mask{rect, {}};
  for (const std::uint8_t value : reader.ReadBytes(real_shadow.Mask(), rect)) {
    mask.values.push_back(static_cast<float>(value) / 255.0f);
  }
  return mask;
}

// Replaces what is drawn of the frame's instant by its means over the exposure.
void Compositor::Impl::MoveLayers(const CompositeInput& input,
                                  const glm::dvec3& to_sun,
                                  Drawn& drawn) {
  MotionBlur motion(*input.motion, input.view, lookup, to_sun, scene.Objects());
  if (!drawn.object_rect.Empty()) {
    const std::span<const glm::vec4> sharp = reader.ReadFloats(*drawn.objects, drawn.object_rect);
    const LayerPart<glm::vec4> moved =
        motion.MoveObjects({drawn.object_rect, {sharp.begin(), sharp.end()}});
    ResetPassState();
    moved_layer.Resize(layer_view.intrinsics.width_px, layer_view.intrinsics.height_px);
    moved_layer.Bind();
    glClear(GL_COLOR_BUFFER_BIT);
    glBindTexture(GL_TEXTURE_2D, moved_layer.ColourTexture());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTexSubImage2D(GL_TEXTURE_2D,
                    0,
                    moved.rect.lower.x,
                    moved.rect.lower.y,
                    moved.rect.Width(),
                    moved.rect.Height(),
                    GL_RGBA,
                    GL_FLOAT,
                    moved.values.data());
    glBindTexture(GL_TEXTURE_2D, 0);
    drawn.objects = &moved_layer;
    drawn.object_rect = moved.rect;
  }
  if (!drawn.shadow_rect.Empty()) {
    const LayerPart<float> mask = ReadMask(drawn.shadow_rect);
    const PixelRect rect = lookup.CameraRectOf(drawn.shadow_rect);
    drawn.shadow_rect = {};
    RealSunShare& share = drawn.moved_sun.emplace();
    share = {rect.lower.x, rect.lower.y, GrayImage(rect.Width(), rect.Height())};
    for (int y = rect.lower.y; y < rect.upper.y; ++y) {
      for (int x = rect.lower.x; x < rect.upper.x; ++x) {
        share.hidden.At(x - rect.lower.x, y - rect.lower.y) = ShadowByMask(mask, lookup, x, y);
      }
    }
    share = motion.Moved(share);
  } else if (drawn.hidden_sun != nullptr) {
    drawn.moved_sun = motion.Moved(*drawn.hidden_sun);
  }
  if (input.irradiance_change != nullptr) {
    drawn.moved_change = motion.Moved(*input.irradiance_change);
  }
}

// Returns the part of the picture that may have changed.
PixelRect Compositor::Impl::CompositeOnDevice(const CompositeInput& input,
                                              const Drawn& drawn,
                                              const CompositeLight& light,
                                              float gain) {
  const int width = input.view.Width();
  const int height = input.view.Height();
  device->change.Clear();
  device->hidden_sun.Clear();
  if (input.irradiance_change != nullptr) {
    const IrradianceChange& change = *input.irradiance_change;
    device->change.Update({change.x_px, change.y_px},
                          change.irradiance_rgb,
                          [](const glm::vec3& irradiance) { return glm::vec4(irradiance, 0.0f); });
  }
  if (drawn.hidden_sun != nullptr) {
    const RealSunShare& real = *drawn.hidden_sun;
    device->hidden_sun.Update({real.x_px, real.y_px}, real.hidden);
  }
  if (drawn.shadow_rect.Empty()) {
    real_shadow.Clear(layer_view.intrinsics.width_px, layer_view.intrinsics.height_px);
  }
  if (drawn.objects == nullptr) {
    object_layer.Clear({layer_view.intrinsics.width_px, layer_view.intrinsics.height_px});
  }
  const FrameBuffer& objects = drawn.objects != nullptr ? *drawn.objects : object_layer.Layer();
  const BlurKernel shadow_blur(input.camera_blur_px);
  const CompositeLayers layers{device->surface,
                               lookup,
                               objects.ColourTexture(),
                               real_shadow.Mask().ColourTexture(),
                               device->change,
                               device->hidden_sun,
                               shadow_blur,
                               lookup.CameraRectOf(drawn.object_rect),
                               lookup.CameraRectOf(drawn.shadow_rect),
                               shadow_blur.Spread(device->hidden_sun.Rect(), width, height)};
  const PixelRect rect = layers.Rect();
  if (rect.Empty()) return rect;
  const PixelRect view_rect = layers.ViewRect(width, height);
  if (!view_rect.Empty()) device->surface.Update(input.view, view_rect);
  device->surface.UpdateCamera(
      input.camera_radiance, input.clipped, layers.CameraRect(width, height));
  device->composite.Draw(layers, light, gain, width, height);
  return rect;
}

void Compositor::Impl::ReadBack(const PixelRect& rect, float gain, Composite& result) {
  if (rect.Empty()) return;
  const std::span<const std::uint16_t> halves = reader.ReadHalves(device->composite.Target(), rect);
  const float to_radiance = 1.0f / gain;
  tbb::parallel_for(rect.lower.y, rect.upper.y, [&](int y) {
    const std::uint16_t* half = &halves[4 * rect.Index({rect.lower.x, y})];
    for (int x = rect.lower.x; x < rect.upper.x; ++x, half += 4) {
      if (half[3] == 0) continue;
      const std::size_t pixel = result.radiance.Index(x, y);
      const glm::vec3 radiance(
          glm::unpackHalf1x16(half[0]), glm::unpackHalf1x16(half[1]), glm::unpackHalf1x16(half[2]));
      result.radiance.pixels[pixel] = to_radiance * radiance;
      const bool is_covered = glm::unpackHalf1x16(half[3]) > 0.75f;
      result.change.pixels[pixel] =
          static_cast<std::uint8_t>(is_covered ? PixelChange::kCovered : PixelChange::kScaled);
    }
  });
}

void Compositor::Impl::CompositeInMemory(const CompositeInput& input,
                                         const Drawn& drawn,
                                         const CompositeLight& light,
                                         float gain,
                                         Composite& result) {
  ProcessorLayers layers{.lookup = lookup,
                         .object = {drawn.object_rect, {}},
                         .mask = {drawn.shadow_rect, {}},
                         .hidden_sun = drawn.hidden_sun,
                         .shadow_blur = BlurKernel(input.camera_blur_px),
                         .object_rect = lookup.CameraRectOf(drawn.object_rect),
                         .mask_rect = lookup.CameraRectOf(drawn.shadow_rect)};
  if (!drawn.object_rect.Empty()) {
    const std::span<const glm::vec4> values = reader.ReadFloats(*drawn.objects, drawn.object_rect);
    layers.object.values.assign(values.begin(), values.end());
  }
  if (!drawn.shadow_rect.Empty()) {
    layers.mask = ReadMask(drawn.shadow_rect);
  }
  CompositeByProcessor(input, layers, light, gain, result);
}

void CompositorOptions::Validate() const {
  const int side = object_samples_per_side;
  if (side >= 2 && side <= SampleLattice::kMostSide && side % 2 == 0) return;
  throw std::invalid_argument("CompositorOptions::object_samples_per_side is " +
                              std::to_string(side) + ": expected 2, 4, 6 or 8");
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

Composite Compositor::Render(const CompositeInput& given) {
  impl_->context.RequireCurrent();
  ValidateInput(given, impl_->scene.Objects());
  const glm::dvec3 to_sun = ValidatedDirection(given.lighting.sun.direction_enu);
  const ApplicationState application_state;
  Composite result;
  Clock::time_point start = Clock::now();
  TakeDrawCount();
  const float gain =
      LayerGain(PeakOf(given.lighting),
                impl_->by_processor ? PeakOnObjects(given) : PeakOf(given.camera_radiance));
  impl_->UpdateLayerView(given.view.camera);
  if (impl_->device) impl_->device->timer.Start();
  Impl::Drawn drawn = impl_->DrawLayers(given, to_sun, gain);
  CompositeInput input = given;
  if (drawn.moved_sun) drawn.hidden_sun = &*drawn.moved_sun;
  if (drawn.moved_change) input.irradiance_change = &*drawn.moved_change;
  CompositeLight light;
  light.to_sun = to_sun;
  light.sun_irradiance = glm::vec3(static_cast<double>(gain) * input.lighting.sun.irradiance_rgb);
  for (const SkyComponent& component : input.lighting.sky) {
    light.sky_irradiance.emplace_back(static_cast<double>(gain) * component.irradiance_rgb);
  }
  const auto lap_ms = [&start] {
    const Clock::time_point now = Clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(start, now)).count();
  };
  const auto copy_picture = [&] {
    result.radiance = input.camera_radiance;
    result.change = Gray8Image(input.camera_radiance.width, input.camera_radiance.height, 0);
  };
  if (impl_->by_processor) {
    glFlush();
    result.draw_ms = lap_ms();
    copy_picture();
    result.readback_ms = lap_ms();
    impl_->CompositeInMemory(input, drawn, light, gain, result);
    result.draw_ms += lap_ms();
  } else {
    const PixelRect rect = impl_->CompositeOnDevice(input, drawn, light, gain);
    impl_->device->timer.Stop();
    glFinish();
    result.draw_ms = lap_ms();
    copy_picture();
    impl_->ReadBack(rect, gain, result);
    result.readback_ms = lap_ms();
    result.device_ms = impl_->device->timer.Ms();
  }
  result.draw_calls = TakeDrawCount();
  impl_->context.RequireNotLost();
  return result;
}

}  // namespace pleinair
