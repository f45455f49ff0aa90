// What the core throws when it is given something it cannot work with.
#pragma once

#include <stdexcept>
#include <string>

namespace glossa {

/// Input that breaks a rule: the message names the quantity, the rule and the value found.
/// Python sees it as glossa.InputError.
class InputError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Throws InputError with `message` unless `rule` holds.
inline void require(bool rule, const std::string& message) {
  if (!rule) throw InputError(message);
}

}  // namespace glossa
