// Rolls a change back at the end of the scope unless dismissed.
#pragma once

#include <utility>

namespace dvdx {

template <class TakeBack>
class Undo {
 public:
  explicit Undo(TakeBack take_back) : take_back_(std::move(take_back)) {}
  Undo(const Undo&) = delete;
  Undo& operator=(const Undo&) = delete;
  ~Undo() {
    if (is_due_) take_back_();
  }
  void dismiss() noexcept { is_due_ = false; }

 private:
  TakeBack take_back_;
  bool is_due_ = true;
};

}  // namespace dvdx
