#include <algorithm>

#include "swiftlet/hal/cmsdk_uart.hpp"

namespace swiftlet::hal {
namespace {

// Word offsets and bits: Arm DDI 0479, table 4-2.
constexpr std::size_t kData = 0;
constexpr std::size_t kState = 1;
constexpr std::size_t kControl = 2;
constexpr std::size_t kInterrupt = 3;  // read: status; write a one: clear
constexpr std::size_t kBaudDivider = 4;
constexpr std::uint32_t kTransmitFull = 1U << 0U;  // of kState
constexpr std::uint32_t kReceiveFull = 1U << 1U;
constexpr std::uint32_t kReceiveOverrun = 1U << 3U;
constexpr std::uint32_t kEnableBothWithInterrupts = 0xF;
constexpr std::uint32_t kTransmitInterrupt = 1U << 0U;
constexpr std::uint32_t kReceiveInterrupt = 1U << 1U;
constexpr std::uint32_t kLeastBaudDivider = 16;

/// Keeps the compiler from moving the bytes of a ring past its index; the Cortex-M's own accesses stay in order.
void order_memory() { asm volatile("" ::: "memory"); }

std::uint32_t disable_interrupts() {
  std::uint32_t mask = 0;
  asm volatile("mrs %0, primask\n cpsid i" : "=r"(mask)::"memory");
  return mask;
}

void restore_interrupts(std::uint32_t mask) { asm volatile("msr primask, %0" ::"r"(mask) : "memory"); }

}  // namespace

void CmsdkUart::Ring::push(std::byte byte) {
  bytes[written % bytes.size()] = byte;
  order_memory();
  written = written + 1;
}

std::byte CmsdkUart::Ring::pop() {
  const std::byte byte = bytes[read % bytes.size()];
  order_memory();
  read = read + 1;
  return byte;
}

CmsdkUart::CmsdkUart(std::uintptr_t base, std::uint32_t clock_hz, std::uint32_t baud)
    : registers_(reinterpret_cast<volatile std::uint32_t*>(base)) {
  registers_[kBaudDivider] = std::max((clock_hz + baud / 2) / baud, kLeastBaudDivider);
  registers_[kControl] = kEnableBothWithInterrupts;
}

std::size_t CmsdkUart::write(std::span<const std::byte> bytes) {
  std::size_t count = 0;
  while (count < bytes.size() && !sent_.full()) sent_.push(bytes[count++]);
  start_transmission();
  return count;
}

std::size_t CmsdkUart::read(std::span<std::byte> into) {
  std::size_t count = 0;
  while (count < into.size() && !received_.empty()) into[count++] = received_.pop();
  return count;
}

void CmsdkUart::on_receive_interrupt() {
  registers_[kInterrupt] = kReceiveInterrupt;
  if ((registers_[kState] & kReceiveOverrun) != 0) {
    registers_[kState] = kReceiveOverrun;
    overruns_ = overruns_ + 1;
  }
  while ((registers_[kState] & kReceiveFull) != 0) {
    const auto byte = static_cast<std::byte>(registers_[kData] & 0xFFU);
    if (received_.full()) {
      overruns_ = overruns_ + 1;
    } else {
      received_.push(byte);
    }
  }
}

void CmsdkUart::on_transmit_interrupt() {
  registers_[kInterrupt] = kTransmitInterrupt;
  while (!sent_.empty() && (registers_[kState] & kTransmitFull) == 0) {
    registers_[kData] = static_cast<std::uint32_t>(sent_.pop());
  }
}

/// The device interrupts when a byte has left, so the first one must be put in by hand.
void CmsdkUart::start_transmission() {
  const std::uint32_t mask = disable_interrupts();
  on_transmit_interrupt();
  restore_interrupts(mask);
}

}  // namespace swiftlet::hal
