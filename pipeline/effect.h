// The effects that can be simulated, and the choice of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>

#include "pipeline/effect_list.h"

namespace pleinair {

#define PLEINAIR_ENUMERATOR(name) k##name,
#define PLEINAIR_ELEMENT(name) Effect::k##name,
enum class Effect : std::uint8_t { PLEINAIR_EFFECTS(PLEINAIR_ENUMERATOR) };
inline constexpr std::array kAllEffects{PLEINAIR_EFFECTS(PLEINAIR_ELEMENT)};
#undef PLEINAIR_ENUMERATOR
#undef PLEINAIR_ELEMENT
inline constexpr std::size_t kEffectCount = kAllEffects.size();

// The name on the command line and in plan.jsonl.
std::string_view NameOf(Effect effect);

// A set of effects.
class EffectSet {
 public:
  constexpr EffectSet() = default;
  constexpr EffectSet(std::initializer_list<Effect> effects) {
    for (const Effect effect : effects) bits_ |= BitOf(effect);
  }
  static constexpr EffectSet All() { return EffectSet((1u << kEffectCount) - 1u); }
  static constexpr EffectSet FromBits(std::uint32_t bits) { return EffectSet(bits); }

  constexpr bool Has(Effect effect) const { return (bits_ & BitOf(effect)) != 0; }
  constexpr bool HasAny(EffectSet others) const { return (bits_ & others.bits_) != 0; }
  constexpr bool HasAll(EffectSet others) const { return (bits_ & others.bits_) == others.bits_; }
  constexpr bool Empty() const { return bits_ == 0; }
  constexpr std::uint32_t Bits() const { return bits_; }
  constexpr EffectSet With(Effect effect) const { return EffectSet(bits_ | BitOf(effect)); }
  constexpr EffectSet Without(Effect effect) const { return EffectSet(bits_ & ~BitOf(effect)); }
  constexpr EffectSet Without(EffectSet others) const { return EffectSet(bits_ & ~others.bits_); }
  bool operator==(const EffectSet&) const = default;

 private:
  explicit constexpr EffectSet(std::uint32_t bits) : bits_(bits) {}
  static constexpr std::uint32_t BitOf(Effect effect) {
    return 1u << static_cast<std::uint32_t>(effect);
  }
  std::uint32_t bits_ = 0;
};

// One line of help.
std::string_view HelpOf(Effect effect);
// The effects that are switched on with it when it is named: its other half.
EffectSet BroughtBy(Effect effect);
// Whether it is a way of computing other effects: on with them, unless switched off by name.
bool IsWayOfOthers(Effect effect);

// kPlan: the plan decides.
enum class EffectSwitch : std::uint8_t { kOff, kPlan, kOn };

// Which effects are asked for, and with which threshold or budget.
struct EffectSettings {
  // By Effect.
  std::array<EffectSwitch, kEffectCount> switches = Filled(EffectSwitch::kPlan);
  // Sum of the changes that may be left out, in code values of the 8-bit picture. >= 0.
  double threshold_code_values = 1.0;
  // Milliseconds for a frame, from the estimate on; the work for a new view or sun before that is
  // the same for all choices. With a budget, the plan chooses the most accurate set of effects that
  // fits, instead of what the threshold allows to leave out.
  std::optional<double> budget_ms;

  EffectSwitch& operator[](Effect effect) { return switches[static_cast<std::size_t>(effect)]; }
  EffectSwitch operator[](Effect effect) const {
    return switches[static_cast<std::size_t>(effect)];
  }
  static constexpr std::array<EffectSwitch, kEffectCount> Filled(EffectSwitch all) {
    std::array<EffectSwitch, kEffectCount> switches{};
    switches.fill(all);
    return switches;
  }
  static EffectSettings Everything() {
    EffectSettings settings;
    settings.switches = Filled(EffectSwitch::kOn);
    return settings;
  }
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

}  // namespace pleinair
