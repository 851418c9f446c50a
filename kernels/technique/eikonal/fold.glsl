// Where waves have met, the wave has a fold.

// Bends (second differences) of neighbouring cells that differ by more than this, and by more than a part of a cell's way, are
// that of a fold and of what is beside it.
const float FOLD = 4.0;
const float FOLD_TURN = 0.02;

// `step` as of a sweep: refractive index times a cell's side.
bool is_fold(float least, float most, float step) {
    return most > FOLD * least + FOLD_TURN * step;
}
