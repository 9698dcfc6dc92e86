// The clock of the playback: its place in the frames, and how it advances.

export interface Place {
  index: number; // of the frame
  blend: number; // of the way to the next, 0..1
}

export class Player {
  isPlaying = false;
  speed = 1; // simulated seconds a second
  private at: number; // s from the start of the times

  // times: rising, or falling for a run backwards.
  constructor(
    private readonly times: readonly number[],
    private loaded = 0, // frames there are so far
  ) {
    this.at = 0;
  }

  get span(): number {
    return Math.abs(this.times.at(-1)! - this.times[0]!);
  }

  get loadedFrames(): number {
    return this.loaded;
  }

  set loadedFrames(count: number) {
    this.loaded = count;
  }

  get elapsed(): number {
    return this.at;
  }

  // Advances the clock. It goes on from the start after the end, and waits for frames that are not loaded yet.
  advance(seconds: number): void {
    if (!this.isPlaying || this.span === 0) return;
    this.at += seconds * this.speed;
    const end = this.since(this.times.length - 1);
    if (this.loaded < this.times.length) this.at = Math.min(this.at, this.since(Math.max(0, this.loaded - 1)));
    else if (this.at > end) this.at = this.at - end < end ? this.at - end : 0;
  }

  seek(seconds: number): void {
    this.at = Math.min(Math.max(0, seconds), this.since(Math.max(0, this.loaded - 1)));
  }

  // Goes to the start of the frame that is `count` frames on.
  stepFrames(count: number): void {
    this.isPlaying = false;
    const { index, blend } = this.place();
    const from = count < 0 && blend > 0 ? index + 1 : index;
    this.at = this.since(Math.min(Math.max(0, from + count), Math.max(0, this.loaded - 1)));
  }

  place(): Place {
    let low = 0;
    let high = Math.max(0, this.loaded - 1);
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.since(middle) <= this.at) low = middle;
      else high = middle - 1;
    }
    if (low + 1 >= this.loaded) return { index: low, blend: 0 };
    const from = this.since(low);
    const length = this.since(low + 1) - from;
    return { index: low, blend: length > 0 ? Math.min(1, Math.max(0, (this.at - from) / length)) : 0 };
  }

  // The simulated time at the end, s.
  get end(): number {
    return this.times.at(-1)!;
  }

  // The simulated time, s.
  time(): number {
    const start = this.times[0]!;
    return this.times.at(-1)! < start ? start - this.at : start + this.at;
  }

  private since(index: number): number {
    return Math.abs(this.times[index]! - this.times[0]!);
  }
}
