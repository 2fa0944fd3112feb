#include <algorithm>
#include <array>
#include <cstdint>

#include "board.hpp"
#include "semihosting.hpp"

extern "C" {
// linker.ld
extern std::uint32_t stack_begin[];
extern std::uint32_t stack_end[];
extern std::uint32_t data_begin[];
extern std::uint32_t data_end[];
extern const std::uint32_t data_image[];
extern std::uint32_t bss_begin[];
extern std::uint32_t bss_end[];
extern void (*const init_array_begin[])();
extern void (*const init_array_end[])();

[[noreturn]] void reset_handler();
// board.cpp
void uart1_receive_handler();
void uart1_transmit_handler();
}

int main(int argc, char** argv);

namespace {

using swiftlet::board::semihosting_exit;

constexpr std::uint32_t kStackPaint = 0xDEADBEEF;
constexpr int kMaxArguments = 32;

/// The words of the command line, as main wants them; the last entry stays null.
struct Arguments {
  std::array<char, 1024> text{};
  std::array<char*, kMaxArguments + 1> words{};
  int count = 0;
};
Arguments arguments;

void split_command_line() {
  if (!swiftlet::board::semihosting_command_line(arguments.text)) return;
  bool in_word = false;
  for (char& c : arguments.text) {
    if (c == '\0') break;
    if (c == ' ') {
      c = '\0';
      in_word = false;
    } else if (!in_word && arguments.count < kMaxArguments) {
      arguments.words[static_cast<std::size_t>(arguments.count++)] = &c;
      in_word = true;
    }
  }
}

void enable_fpu() {
  auto* const coprocessor_access = reinterpret_cast<volatile std::uint32_t*>(0xE000ED88);
  *coprocessor_access = *coprocessor_access | (0xFU << 20);  // full access to CP10 and CP11
  asm volatile("dsb\n isb" ::: "memory");
}

void write_hex(std::uint32_t value) {
  std::array<char, 8> digits{};
  for (std::size_t i = 0; i < digits.size(); ++i) digits[i] = "0123456789abcdef"[(value >> (28 - 4 * i)) & 0xF];
  swiftlet::board::console().write(digits);
}

/// `frame` is what the processor stacked: r0 to r3, r12, lr, pc, xpsr.
extern "C" [[noreturn]] void report_fault(const std::uint32_t* frame) {
  const auto* const configurable_fault_status = reinterpret_cast<volatile std::uint32_t*>(0xE000ED28);
  auto& console = swiftlet::board::console();
  console.write(std::span("fault, CFSR ").first(12));
  write_hex(*configurable_fault_status);
  const bool frame_readable = frame >= stack_begin && frame + 8 <= stack_end;
  console.write(std::span(" pc ").first(4));
  write_hex(frame_readable ? frame[6] : 0);
  console.write(std::span("\n").first(1));
  semihosting_exit(255);
}

[[gnu::naked, noreturn]] void fault_handler() {
  // A fault of the stack itself must not fault again: report on a fresh one.
  asm volatile(
      "mrs r0, msp\n"
      "ldr r1, =stack_end\n"
      "msr msp, r1\n"
      "b report_fault\n");
}

struct VectorTable {
  std::uint32_t* initial_stack;
  std::array<void (*)(), 15> exceptions;
  std::array<void (*)(), 4> interrupts;
};

/// Reset, then every exception of the core, then the interrupts that the board enables.
[[gnu::section(".vectors"), gnu::used]] const VectorTable kVectors{
    stack_end,
    {reset_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, nullptr, nullptr,
     nullptr, nullptr, fault_handler, fault_handler, nullptr, fault_handler, fault_handler},
    {fault_handler, fault_handler, uart1_receive_handler, uart1_transmit_handler}};

}  // namespace

extern "C" [[noreturn, gnu::noinline]] void run_program() {
  std::for_each(init_array_begin, init_array_end, [](void (*constructor)()) { constructor(); });
  split_command_line();
  semihosting_exit(main(arguments.count, arguments.words.data()));
}

/// The processor starts here with an undefined FPU and memory; nothing below `run_program` may come before its set-up.
extern "C" void reset_handler() {
  enable_fpu();
  std::copy(data_image, data_image + (data_end - data_begin), data_begin);
  std::fill(bss_begin, bss_end, 0U);
  std::uint32_t* stack_pointer = nullptr;
  asm volatile("mov %0, sp" : "=r"(stack_pointer));
  std::fill(stack_begin, stack_pointer - 16, kStackPaint);
  run_program();
}

namespace swiftlet::board {

std::size_t stack_bytes_used() {
  const std::uint32_t* const lowest_used =
      std::find_if(stack_begin, stack_end, [](std::uint32_t word) { return word != kStackPaint; });
  return static_cast<std::size_t>(stack_end - lowest_used) * sizeof(std::uint32_t);
}

}  // namespace swiftlet::board
