// The one list of effects, in the order in which they are planned, computed and reported.
#pragma once

// An effect `Penumbra` is Effect::kPenumbra, and internal/effects/penumbra.cpp defines
// kPenumbraEffect: its name, help, bound, works and drawing (internal/effects/frame_effect.h).
#define PLEINAIR_EFFECTS(EFFECT) \
  EFFECT(SunShading)             \
  EFFECT(SunShadow)              \
  EFFECT(ObjectShadow)           \
  EFFECT(Penumbra)               \
  EFFECT(ProbeShading)           \
  EFFECT(LocalLight)             \
  EFFECT(AmbientOcclusion)       \
  EFFECT(LightUpdate)            \
  EFFECT(Daylight)               \
  EFFECT(SkyOcclusion)           \
  EFFECT(ColourBleeding)         \
  EFFECT(GlossyReflection)       \
  EFFECT(MotionBlur)             \
  EFFECT(CameraBlur)             \
  EFFECT(CameraNoise)
