#include "apps/camera_stand_in/shim/controls.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace pleinair::stand_in {
namespace {

struct ControlInfo {
  std::uint32_t id;
  std::uint32_t type;
  const char* name;
  std::int32_t minimum;
  std::int32_t maximum;
  std::int32_t step;
  std::int32_t normal;  // The default.
  std::uint32_t flags;
};

constexpr std::uint32_t kClassFlags = V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_WRITE_ONLY;

// By id, as enumeration goes.
constexpr std::array<ControlInfo, kControlCount> kControls{{
    {V4L2_CID_USER_CLASS, V4L2_CTRL_TYPE_CTRL_CLASS, "User Controls", 0, 0, 0, 0, kClassFlags},
    // Deprecated, but the only control that states it.
    {V4L2_CID_BLACK_LEVEL,
     V4L2_CTRL_TYPE_INTEGER,
     "Black Level",
     0,
     256,
     1,
     0,
     V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_VOLATILE},
    {V4L2_CID_AUTO_WHITE_BALANCE,
     V4L2_CTRL_TYPE_BOOLEAN,
     "White Balance, Automatic",
     0,
     1,
     1,
     1,
     V4L2_CTRL_FLAG_UPDATE},
    {V4L2_CID_GAIN, V4L2_CTRL_TYPE_INTEGER, "Gain", 100, 1600, 1, 100, 0},  // 100: factor 1.
    {V4L2_CID_WHITE_BALANCE_TEMPERATURE,
     V4L2_CTRL_TYPE_INTEGER,
     "White Balance Temperature",
     2000,
     10000,
     10,
     6500,
     0},
    {V4L2_CID_CAMERA_CLASS, V4L2_CTRL_TYPE_CTRL_CLASS, "Camera Controls", 0, 0, 0, 0, kClassFlags},
    {V4L2_CID_EXPOSURE_AUTO,
     V4L2_CTRL_TYPE_MENU,
     "Auto Exposure",
     V4L2_EXPOSURE_AUTO,
     V4L2_EXPOSURE_APERTURE_PRIORITY,
     0,
     V4L2_EXPOSURE_APERTURE_PRIORITY,
     V4L2_CTRL_FLAG_UPDATE},
    {V4L2_CID_EXPOSURE_ABSOLUTE,
     V4L2_CTRL_TYPE_INTEGER,
     "Exposure Time, Absolute",  // In units of 100 microseconds.
     1,
     5000,
     1,
     100,
     0},
}};

constexpr int kNone = -1;

int IndexOf(std::uint32_t id) {
  for (int i = 0; i < kControlCount; ++i) {
    if (kControls[i].id == id) return i;
  }
  return kNone;
}

std::int32_t Stored(const DeviceState& state, std::uint32_t id) {
  return state.controls[static_cast<std::size_t>(IndexOf(id))];
}

bool ExposesByItself(const DeviceState& state) {
  return Stored(state, V4L2_CID_EXPOSURE_AUTO) != V4L2_EXPOSURE_MANUAL;
}
bool BalancesByItself(const DeviceState& state) {
  return Stored(state, V4L2_CID_AUTO_WHITE_BALANCE) != 0;
}

bool IsInactive(const DeviceState& state, const ControlInfo& info) {
  return (info.id == V4L2_CID_EXPOSURE_ABSOLUTE && ExposesByItself(state)) ||
         (info.id == V4L2_CID_WHITE_BALANCE_TEMPERATURE && BalancesByItself(state));
}

// What the camera uses now: automatic exposure and white balance are those of the recording.
std::int32_t Value(const DeviceState& state, int index) {
  const ControlInfo& info = kControls[index];
  if (info.id == V4L2_CID_BLACK_LEVEL) {
    const int bits = RawBits(state.format.pixel_format);
    return bits == 0 ? 0 : BlackLevel(bits);
  }
  return IsInactive(state, info) ? info.normal : state.controls[index];
}

bool IsFaulty(DeviceState& state, FaultKind kind) {
  constexpr std::int64_t kPictures = 30;
  const std::int64_t lasts = state.faults_count_pictures ? kPictures : kSecondNs;
  const std::int64_t now = state.FaultClock();
  for (int i = 0; i < state.fault_count; ++i) {
    Fault& fault = state.faults[i];
    if (fault.at > now) break;
    if (fault.kind == kind && now < fault.at + lasts) return fault.struck = true;
  }
  return false;
}

bool HasMenuItem(std::int32_t value) {
  return value == V4L2_EXPOSURE_MANUAL || value == V4L2_EXPOSURE_APERTURE_PRIORITY;
}

// Rounds an integer into its range, as the kernel does; refuses a menu's unknown item.
int Admit(DeviceState& state, int index, std::int32_t& value) {
  const ControlInfo& info = kControls[index];
  if ((info.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0) return EACCES;
  if (info.type == V4L2_CTRL_TYPE_MENU) {
    if (value < info.minimum || value > info.maximum) return ERANGE;
    return HasMenuItem(value) ? 0 : EINVAL;
  }
  if (info.type == V4L2_CTRL_TYPE_BOOLEAN) {
    value = value != 0 ? 1 : 0;
    return 0;
  }
  value = std::clamp(value, info.minimum, info.maximum);
  value = info.minimum + (value - info.minimum + info.step / 2) / info.step * info.step;
  value = std::min(value, info.maximum);
  const std::int32_t tenth = info.normal / 10;
  const std::int32_t clamped =
      std::clamp(value, std::max(info.minimum, info.normal - tenth), info.normal + tenth);
  if (clamped != value && IsFaulty(state, FaultKind::kControlClamped)) value = clamped;
  return 0;
}

Gains GainsOf(const DeviceState& state) {
  const auto ratio = [&](std::uint32_t id) {
    const int index = IndexOf(id);
    return static_cast<float>(Value(state, index)) / static_cast<float>(kControls[index].normal);
  };
  const float brightness = ratio(V4L2_CID_EXPOSURE_ABSOLUTE) * ratio(V4L2_CID_GAIN);
  // A higher temperature is that of bluer light, which the camera then balances towards red.
  const float warmth = std::sqrt(ratio(V4L2_CID_WHITE_BALANCE_TEMPERATURE));
  return {brightness * warmth, brightness, brightness / warmth};
}

void ScheduleGains(DeviceState& state) {
  const Gains gains = GainsOf(state);
  if (!state.is_streaming) {
    state.gains = gains;
    state.pending_count = 0;
    return;
  }
  const std::int64_t from = state.frame - 1 + state.control_delay;
  int& count = state.pending_count;
  if (count == 0 || state.pending[count - 1].from_frame < from) ++count;
  state.pending[count - 1] = {from, gains};
}

std::uint32_t ClassOf(std::uint32_t id) { return id & 0x0fff0000u; }

}  // namespace

int BlackLevel(int bits) { return 1 << (bits - 4); }

int RawBits(std::uint32_t pixel_format) {
  switch (pixel_format) {
    case V4L2_PIX_FMT_SRGGB8:
      return 8;
    case V4L2_PIX_FMT_SRGGB10:
    case V4L2_PIX_FMT_SRGGB10P:
      return 10;
    case V4L2_PIX_FMT_SRGGB12:
    case V4L2_PIX_FMT_SRGGB12P:
      return 12;
    default:
      return 0;
  }
}

int QueryControl(const DeviceState& state, v4l2_query_ext_ctrl& query) {
  const bool next = (query.id & V4L2_CTRL_FLAG_NEXT_CTRL) != 0;
  const std::uint32_t id = query.id & V4L2_CTRL_ID_MASK;
  if (!next && (query.id & V4L2_CTRL_FLAG_NEXT_COMPOUND) != 0) return EINVAL;
  for (const ControlInfo& info : kControls) {
    if (next ? info.id <= id : info.id != id) continue;
    query = {};
    query.id = info.id;
    query.type = info.type;
    std::strncpy(query.name, info.name, sizeof query.name - 1);
    query.minimum = info.minimum;
    query.maximum = info.maximum;
    query.step = info.type == V4L2_CTRL_TYPE_MENU ? 1 : info.step;
    query.default_value = info.normal;
    query.flags = info.flags | (IsInactive(state, info) ? V4L2_CTRL_FLAG_INACTIVE : 0u);
    query.elem_size = sizeof(std::int32_t);
    query.elems = 1;
    return 0;
  }
  return EINVAL;
}

int QueryMenu(v4l2_querymenu& query) {
  if (query.id != V4L2_CID_EXPOSURE_AUTO || !HasMenuItem(static_cast<std::int32_t>(query.index))) {
    return EINVAL;
  }
  const char* name = query.index == V4L2_EXPOSURE_MANUAL ? "Manual Mode" : "Aperture Priority Mode";
  std::memset(query.name, 0, sizeof query.name);
  std::memcpy(query.name, name, std::strlen(name));
  query.reserved = 0;
  return 0;
}

int GetControl(const DeviceState& state, v4l2_control& control) {
  const int index = IndexOf(control.id);
  if (index == kNone) return EINVAL;
  if ((kControls[index].flags & V4L2_CTRL_FLAG_WRITE_ONLY) != 0) return EACCES;
  control.value = Value(state, index);
  return 0;
}

int SetControl(DeviceState& state, v4l2_control& control) {
  const int index = IndexOf(control.id);
  if (index == kNone) return EINVAL;
  if (const int error = Admit(state, index, control.value)) return error;
  if (IsFaulty(state, FaultKind::kControlRefused)) return EBUSY;
  state.controls[index] = control.value;
  ScheduleGains(state);
  return 0;
}

int GetControls(const DeviceState& state, v4l2_ext_controls& controls) {
  for (std::uint32_t i = 0; i < controls.count; ++i) {
    v4l2_ext_control& one = controls.controls[i];
    const int index = IndexOf(one.id);
    controls.error_idx = controls.count;
    if (index == kNone ||
        (controls.which != V4L2_CTRL_WHICH_CUR_VAL && controls.which != V4L2_CTRL_WHICH_DEF_VAL &&
         controls.which != ClassOf(one.id))) {
      return EINVAL;
    }
    if ((kControls[index].flags & V4L2_CTRL_FLAG_WRITE_ONLY) != 0) return EACCES;
    one.value =
        controls.which == V4L2_CTRL_WHICH_DEF_VAL ? kControls[index].normal : Value(state, index);
  }
  controls.error_idx = controls.count;
  return 0;
}

int SetControls(DeviceState& state, bool try_only, v4l2_ext_controls& controls) {
  if (controls.which == V4L2_CTRL_WHICH_DEF_VAL) return EINVAL;
  // Nothing is written where one of them is refused.
  for (std::uint32_t i = 0; i < controls.count; ++i) {
    v4l2_ext_control& one = controls.controls[i];
    controls.error_idx = try_only ? i : controls.count;
    const int index = IndexOf(one.id);
    if (index == kNone ||
        (controls.which != V4L2_CTRL_WHICH_CUR_VAL && controls.which != ClassOf(one.id))) {
      return EINVAL;
    }
    std::int32_t value = one.value;  // The structure is packed.
    if (const int error = Admit(state, index, value)) return error;
    one.value = value;
  }
  controls.error_idx = controls.count;
  if (try_only || controls.count == 0) return 0;
  if (IsFaulty(state, FaultKind::kControlRefused)) {
    controls.error_idx = 0;
    return EBUSY;
  }
  for (std::uint32_t i = 0; i < controls.count; ++i) {
    state.controls[static_cast<std::size_t>(IndexOf(controls.controls[i].id))] =
        controls.controls[i].value;
  }
  ScheduleGains(state);
  return 0;
}

void ResetControls(DeviceState& state) {
  for (int i = 0; i < kControlCount; ++i) state.controls[i] = kControls[i].normal;
  ScheduleGains(state);
}

void AdvanceGains(DeviceState& state) {
  int due = 0;
  while (due < state.pending_count && state.pending[due].from_frame <= state.frame) {
    state.gains = state.pending[due++].gains;
  }
  std::copy(state.pending.begin() + due,
            state.pending.begin() + state.pending_count,
            state.pending.begin());
  state.pending_count -= due;
}

}  // namespace pleinair::stand_in
