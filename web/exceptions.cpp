// SPDX-License-Identifier: Apache-2.0

// Throws and catches C++ exceptions in WebAssembly: the half of the C++ runtime that Debian's
// libc++abi for it lacks. The compiler's side of this contract is -fwasm-exceptions; tables and
// functions are those of the Itanium C++ ABI for exception handling, but that unwinding is the
// machine's own work. There are no threads, no exception specifications and no foreign exceptions.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <typeinfo>

namespace __cxxabiv1 {

// libc++abi's own type information, which knows what a catch clause takes.
class __shim_type_info : public std::type_info {
 public:
  ~__shim_type_info() override;
  virtual void noop1() const;
  virtual void noop2() const;
  virtual bool can_catch(const __shim_type_info* thrown, void*& object) const = 0;
};

}  // namespace __cxxabiv1

namespace {

// Stands before the object that was thrown.
struct alignas(16) Header {
  const __cxxabiv1::__shim_type_info* type;
  void* (*destroy)(void*);  // destructors return their object on this machine
  void* caught_as;          // the object, as the catch clause's type
  Header* next_caught;      // the exception that was being handled before
  int handlers;             // in which it is being handled
  bool is_rethrown;

  void* object() { return this + 1; }
};

Header* caught = nullptr;

// Landing pads get the pointer that is thrown here.
[[noreturn]] void raise(Header* header) {
  constexpr int cpp_exception = 0;
  __builtin_wasm_throw(cpp_exception, header);
}

uint32_t read_uleb(const uint8_t*& at) {
  uint32_t value = 0;
  for (int shift = 0;; shift += 7) {
    const uint8_t byte = *at++;
    value |= uint32_t{byte & 0x7fU} << shift;
    if ((byte & 0x80U) == 0) return value;
  }
}

int32_t read_sleb(const uint8_t*& at) {
  uint32_t value = 0;
  for (int shift = 0;;) {
    const uint8_t byte = *at++;
    value |= uint32_t{byte & 0x7fU} << shift;
    shift += 7;
    if ((byte & 0x80U) != 0) continue;
    const bool is_negative = (byte & 0x40U) != 0 && shift < 32;
    return static_cast<int32_t>(is_negative ? value | ~0U << shift : value);
  }
}

// Which of a landing pad's clauses takes the exception: its number in the function's table of
// types, or 0.
uintptr_t find_clause(const uint8_t* table, uintptr_t landing_pad, Header& header) {
  constexpr uint8_t omitted = 0xff;
  using Type = const __cxxabiv1::__shim_type_info*;
  ++table;  // no base of landing pads
  const Type* types = nullptr;
  if (*table++ != omitted) {
    const uint32_t to_types = read_uleb(table);
    types = reinterpret_cast<const Type*>(table + to_types);
  }
  ++table;  // numbers are always in LEB128
  const uint32_t size = read_uleb(table);
  const uint8_t* const actions = table + size;
  for (uintptr_t pad = 0; pad <= landing_pad; ++pad) {
    read_uleb(table);
    const uint32_t action = read_uleb(table);
    if (pad < landing_pad || action == 0) continue;
    for (const uint8_t* at = actions + action - 1;;) {
      const int32_t clause = read_sleb(at);
      if (clause > 0) {
        const Type type = *(types - clause);
        header.caught_as = header.object();
        if (type == nullptr || type->can_catch(header.type, header.caught_as)) {
          return static_cast<uintptr_t>(clause);
        }
      }
      const uint8_t* const here = at;
      const int32_t to_next = read_sleb(at);
      if (to_next == 0) return 0;
      at = here + to_next;
    }
  }
  return 0;
}

}  // namespace

extern "C" {

// What compiled code and the function below it tell each other.
struct LandingPad {
  uintptr_t index;
  const uint8_t* table;
  uintptr_t clause;
} __wasm_lpad_context;

int _Unwind_CallPersonality(void* exception) {
  auto& pad = __wasm_lpad_context;
  pad.clause = find_clause(pad.table, pad.index, *static_cast<Header*>(exception));
  return 0;
}

// Named in what is compiled, never called.
void __gxx_personality_wasm0() {}

void* __cxa_allocate_exception(size_t size) noexcept {
  auto* header =
      static_cast<Header*>(std::aligned_alloc(16, sizeof(Header) + (size + 15) / 16 * 16));
  if (header == nullptr) std::terminate();
  return header->object();
}

void __cxa_free_exception(void* object) noexcept { std::free(static_cast<Header*>(object) - 1); }

[[noreturn]] void __cxa_throw(void* object, std::type_info* type, void* (*destroy)(void*)) {
  Header* header = static_cast<Header*>(object) - 1;
  *header = {};
  header->type = static_cast<const __cxxabiv1::__shim_type_info*>(type);
  header->destroy = destroy;
  header->caught_as = object;
  raise(header);
}

void* __cxa_begin_catch(void* exception) noexcept {
  auto* header = static_cast<Header*>(exception);
  header->is_rethrown = false;
  if (header->handlers++ == 0) {
    header->next_caught = caught;
    caught = header;
  }
  return header->caught_as;
}

void __cxa_end_catch() {
  Header* header = caught;
  if (--header->handlers > 0) return;
  caught = header->next_caught;
  if (header->is_rethrown) return;
  if (header->destroy != nullptr) header->destroy(header->object());
  __cxa_free_exception(header->object());
}

[[noreturn]] void __cxa_rethrow() {
  if (caught == nullptr) std::terminate();
  caught->is_rethrown = true;
  raise(caught);
}

}  // extern "C"
