
/* ---- Errors of trials, and the end of learning that makes them worse. ---- */

/* Note the error of a trial; 1 if it is the least so far. Two worse ones in succession end the learning. */
static int note_progress(block_state *state, double error)
{
    const double least = state->trials > 0 ? state->least : INFINITY;
    const double before = state->trials > 0 ? state->before : INFINITY;
    const double limit = WORSE * least > before ? WORSE * least : before;
    state->worse = error > FAR_WORSE * least || error > limit ? state->worse + 1 : 0;
    state->stopped = STOP_AFTER > 0 && state->worse >= STOP_AFTER;
    state->before = error;
    state->trials++;
    if (!(error < least)) return 0;
    state->least = error;
    return 1;
}
