//! The code that runs from memory without wait states (`firmware/memory/fast.x`): copied there before anything runs.

// What cortex-m-rt calls first, before variables have their values: nothing of Rust can be relied on yet. Word by word from
// where the code is stored to where it was linked; the barriers see to it that it is there before it is fetched.
core::arch::global_asm!(
    ".section .text.__pre_init,\"ax\",%progbits",
    ".global __pre_init",
    ".type __pre_init,%function",
    ".thumb_func",
    "__pre_init:",
    "ldr r0, =__sfast",
    "ldr r1, =__efast",
    "ldr r2, =__sifast",
    "0:",
    "cmp r1, r0",
    "beq 1f",
    "ldm r2!, {{r3}}",
    "stm r0!, {{r3}}",
    "b 0b",
    "1:",
    "dsb",
    "isb",
    "bx lr",
    ".ltorg",
);
