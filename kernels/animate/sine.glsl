// Sine and cosine of an angle in 2^-32 turns. GLSL's own promise no more than 2^-11 within half a turn; these are within
// 1e-7, and the angle wraps by itself.
void sine_cosine(uint turns, out float sine, out float cosine) {
    uint quarter = (turns + 0x20000000u) >> 30;
    // Within an eighth of a turn of the nearest quarter.
    float x = float(int(turns - (quarter << 30))) * 1.4629180792671596e-9; // 2 pi / 2^32
    float x2 = x * x;
    // Minimax polynomials of Cephes' sinf and cosf.
    float s = x + x * x2 * (-1.6666654611e-1 + x2 * (8.3321608736e-3 - x2 * 1.9515295891e-4));
    float c = 1.0 - 0.5 * x2 + x2 * x2 * (4.166664568e-2 + x2 * (-1.388731625e-3 + x2 * 2.443315712e-5));
    bool swapped = (quarter & 1u) != 0u;
    sine = swapped ? c : s;
    cosine = swapped ? s : c;
    if (quarter == 2u || quarter == 3u) sine = -sine;
    if (quarter == 1u || quarter == 2u) cosine = -cosine;
}
