import { expect, test } from 'vitest';
import { Player } from '../src/playback/player';

const played = (times: number[]): Player => {
  const player = new Player(times, times.length);
  player.isPlaying = true;
  return player;
};

test('time goes by the speed, and a place lies between two frames', () => {
  const player = played([0, 1, 3]);
  player.speed = 2;
  player.advance(1);
  expect(player.time()).toBe(2);
  expect(player.place()).toEqual({ index: 1, blend: 0.5 });
});

test('after the end it starts again', () => {
  const player = played([0, 1, 3]);
  player.advance(3.5);
  expect(player.time()).toBe(0.5);
});

test('it waits for frames that are not loaded', () => {
  const player = new Player([0, 1, 2, 3], 2);
  player.isPlaying = true;
  player.advance(2.5);
  expect(player.time()).toBe(1);
  player.loadedFrames = 4;
  player.advance(0.5);
  expect(player.time()).toBe(1.5);
});

test('a run backwards has falling times', () => {
  const player = played([0, -1, -2]);
  player.advance(1.25);
  expect(player.time()).toBe(-1.25);
  expect(player.place()).toEqual({ index: 1, blend: 0.25 });
});

test('a step to a frame pauses, and back from between two goes to the start of the one', () => {
  const player = played([0, 1, 2]);
  player.seek(1.5);
  player.stepFrames(-1);
  expect(player.isPlaying).toBe(false);
  expect(player.time()).toBe(1);
  player.stepFrames(5);
  expect(player.time()).toBe(2);
});

test('one state alone stays', () => {
  const player = played([4]);
  player.advance(1);
  expect(player.place()).toEqual({ index: 0, blend: 0 });
  expect(player.time()).toBe(4);
});
