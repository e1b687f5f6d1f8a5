// From the boot ROM to main(): the second boot stage, the vectors, and the copy of the program into RAM.
.syntax unified
.cpu cortex-m0plus
.thumb

// The boot ROM copies the flash's first 256 bytes into RAM, checks their CRC-32, and runs them. They set up the
// SSI so that the flash is read in place, by the serial command 03h, which all flash chips know.
.section .boot2, "ax"
  ldr r3, =0x18000000     // XIP_SSI_BASE
  movs r1, #0
  str r1, [r3, #0x08]     // SSIENR: off while it is set up
  movs r1, #4
  str r1, [r3, #0x14]     // BAUDR: clk_sys / 4
  ldr r1, =0x001f0300     // DFS_32 = 31: 32 clocks a frame; TMOD = EEPROM_READ
  str r1, [r3, #0x00]     // CTRLR0
  movs r1, #0
  str r1, [r3, #0x04]     // CTRLR1: one frame a read
  ldr r1, =0x03000218     // XIP_CMD = 03h; INST_L: 8 bits; ADDR_L: 24 bits
  movs r2, #0xf4
  str r1, [r3, r2]        // SPI_CTRLR0
  movs r1, #1
  str r1, [r3, #0x08]     // SSIENR: on
  ldr r0, =0x10000100     // vectors
  ldr r1, =0xe000ed08     // VTOR
  str r0, [r1]
  ldr r1, [r0, #0]
  msr msp, r1
  ldr r1, [r0, #4]
  bx r1
  .ltorg
  .org 252, 0
  .word 0                 // CRC-32 of these bytes: make_image writes it

.section .vectors, "a"
  .word stack_top
  .word reset
  .rept 14                // NMI, HardFault, ... SysTick: whatever comes, the watchdog ends it
  .word hang
  .endr

.section .start, "ax"
.globl reset
.thumb_func
reset:
  ldr r0, =ram_begin
  ldr r1, =ram_end
  ldr r2, =ram_in_flash
copy:
  cmp r0, r1
  bhs clear_from
  ldmia r2!, {r3}
  stmia r0!, {r3}
  b copy
clear_from:
  ldr r1, =bss_end
  movs r3, #0
clear:
  cmp r0, r1
  bhs run
  stmia r0!, {r3}
  b clear
run:
  ldr r0, =main
  blx r0
.thumb_func
hang:
  b hang
