// The poses to which the motions of a scene carry their followers.
import * as THREE from 'three';
import type { Motion, MotionKey, Vector } from './scene';

// Returns the rotation of a rotation vector: axis times angle, rad.
export function turnBy([x, y, z]: Vector): THREE.Quaternion {
  const angle = Math.hypot(x, y, z);
  if (angle === 0) return new THREE.Quaternion();
  return new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(x, y, z).divideScalar(angle), angle);
}

interface Pose {
  translation: THREE.Vector3;
  turn: THREE.Quaternion;
}

const poseAt = ({ translation, rotation }: MotionKey): Pose => ({ translation: new THREE.Vector3(...translation), turn: turnBy(rotation) });

// Between keys the translation is linear, and the turn goes about a fixed axis at a constant rate, the short way round. Before
// a jump the pose is held.
function poseOf(keys: readonly MotionKey[], time: number): Pose {
  const next = keys.findIndex((key) => key.time > time);
  if (next === 0) return poseAt(keys[0]!);
  if (next < 0) return poseAt(keys.at(-1)!);
  const before = keys[next - 1]!;
  const after = keys[next]!;
  if (after.jump) return poseAt(before);
  const part = (time - before.time) / (after.time - before.time);
  const from = poseAt(before);
  const to = poseAt(after);
  return { translation: from.translation.lerp(to.translation, part), turn: from.turn.slerp(to.turn, part) };
}

// Returns the matrix that takes a point p to center + R (p - center) + translation.
export function placement({ center, keys }: Motion, time: number): THREE.Matrix4 {
  const { translation, turn } = poseOf(keys, time);
  const middle = new THREE.Vector3(...center);
  const place = translation.add(middle).sub(middle.applyQuaternion(turn));
  return new THREE.Matrix4().compose(place, turn, new THREE.Vector3(1, 1, 1));
}
